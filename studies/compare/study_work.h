// StudyWork is the work of the engine of studies: independent computations, each known by the digest of all
// that decides its result. A comparison's prints, the parts of the papers, pairs of prints that hold a
// promise against nature and the cases of a bench are such work: journals, shards, status and other computers
// serve them alike.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "report/study/study_analysis.h"
#include "studies/compare/study_journal.h"

namespace firn {

/// Each kind of computation is made for each part and each seed.
class StudyWork {
 public:
  virtual ~StudyWork() = default;

  std::string name;                ///< of the study
  std::string noun = "print";      ///< one computation, in messages
  std::vector<std::string> kinds;  ///< schemes of a comparison
  std::vector<double> seconds;  ///< processor time of one computation of each kind [s]; empty: not known, and
                                ///< alike for each shard to take as many of each
  std::vector<std::string> parts{""};
  std::vector<std::uint64_t> seeds{0};
  std::vector<report::StudyMetric> values;  ///< numbers of one result
  std::vector<StudyCell> cells;             ///< seed by seed, so that the finished cells are always balanced

  /// Makes one. Several threads may call it; a failure is a result. @throws std::bad_alloc
  virtual StudyPrint make(const StudyCell& cell) const = 0;
  /// Told of all of them before the first is made. @returns true: they tell their progress on stderr
  /// themselves
  virtual bool tells_progress(const std::vector<const StudyCell*>& /*to_make*/) const { return false; }
};

/// A share of a study's prints: number `number`, from 1, of `of`.
struct StudyShard {
  int number = 1, of = 1;
};

struct StudyRunOptions {
  int threads = 0;             ///< 0 = as many as the machine has
  StudyShard shard = {};       ///< prints these alone
  std::size_t most = 0;        ///< prints; 0 = all
  bool first_of_each = false;  ///< one print of each kind of unknown time that has none on record
  bool again = false;          ///< prints on record that stopped before their end, and no others
  const std::atomic<bool>* stop = nullptr;                             ///< set: no new print is begun
  std::function<void(std::size_t done, std::size_t failed)> progress;  ///< of the prints that were to do
};

struct StudyRunSummary {
  std::size_t to_do = 0, done = 0;
  double cpu_s = 0.0;  ///< of the prints made now
};

/// Returns the prints that run_study() would make, in the order of the work.
std::vector<const StudyCell*> prints_to_do(const StudyWork& work, const StudyJournal& journal,
                                           const StudyRunOptions& options);

/// Makes the results that are not on record yet, on several threads.
/// @throws the journal's exceptions; a print that fails is a result.
StudyRunSummary run_study(const StudyWork& work, StudyJournal& journal, const StudyRunOptions& options);

}  // namespace firn
