// PromisePairs prints with the old and the new setting, in pairs on the same disturbances, in the lab of the
// recorded experiment itself; verification_of says whether the promise held.
#pragma once

#include <cstdint>
#include <span>

#include "core/statistics/comparison.h"
#include "studies/compare/study_work.h"
#include "studies/tune/advice.h"

namespace firn::tune {

/// The settings that are compared, and the number of pairs.
struct PairSettings {
  Setting old_setting, new_setting;
  int pairs = 10;
  std::uint64_t seed = 1;  ///< of the pairs; none is the recorded print's
};

/// Two kinds of prints, each under the seeds of the pairs.
class PromisePairs : public StudyWork {
 public:
  /// @throws UsageError: an instrument of the recorded lab is real: its prints are the operator's
  PromisePairs(const RecordedRun& run, std::span<const TuneKey> keys, const PairSettings& settings);

  StudyPrint make(const StudyCell& cell) const override;

 private:
  const StudyLab& lab_;
  Experiment experiments_[2];
  Blobs inputs_[2];
};

struct Verification {
  statistics::PairedComparison pairs;  ///< a: old, b: new, of the goal
  int stopped_old = 0, stopped_new = 0;
  bool held = false;  ///< the measured gain lies within the promised interval
};

/// @param goal index of the metric. @pre every pair is on record
Verification verification_of(const PromisePairs& work, const StudyJournal& journal, const Promise& promise,
                             std::size_t goal);

}  // namespace firn::tune
