// verify_promise prints with the old and the new setting, in pairs on the same disturbances, in the lab of
// the recorded experiment itself, and says whether the promise held.
#pragma once

#include <span>

#include "core/statistics/comparison.h"
#include "studies/tune/advice.h"

namespace firn::tune {

struct Verification {
  statistics::PairedComparison pairs;  ///< a: old, b: new, of the goal
  int stopped_old = 0, stopped_new = 0;
  bool held = false;  ///< the measured gain lies within the promised interval
};

struct VerifyOptions {
  std::size_t goal = 0;
  int prints = 10;
  std::uint64_t seed = 1;  ///< of the pairs; none is the recorded print's
  int threads = 1;
  Progress progress = {};
};

/// @throws UsageError: an instrument of the recorded lab is real: its prints are the operator's
Verification verify_promise(const RecordedRun& run, std::span<const TuneKey> keys, const Advice& advice,
                            const VerifyOptions& options);

}  // namespace firn::tune
