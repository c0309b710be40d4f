// The seals of a run folder, RUN/seals/<n>.seal: one when an incarnation begins and one when it ends, each
// with the digest of the seal before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runs/folder/run_folder.h"
#include "runs/folder/seal_check.h"

namespace firn::runs {

/// Seals an incarnation: where it begins and, with ended(), where it ends. Without ended(), as after a kill,
/// the run counts as not sealed since this incarnation began. The caller holds the run (run_lock.h).
class SealedIncarnation {
 public:
  /// @param resume the folder is compared with its seals first
  /// @param unsealed resume although it differs; the seal records the differences
  /// @throws UsageError: it differs; std::runtime_error naming file and reason
  SealedIncarnation(const std::filesystem::path& run, std::int64_t run_id, bool resume, bool unsealed);

  /// If the seal cannot be written, as on a full disk, `result` becomes a safety stop that names file and
  /// reason; a resume seals the run or goes on (seal_end).
  void ended(RunResult& result);

 private:
  std::filesystem::path run_;
};

/// Seals a run anew whose log was repaired. Does nothing where the newest incarnation is not sealed yet.
/// @param before of the run before the repair; its differences are recorded
void seal_repaired(const std::filesystem::path& run, const SealCheck& before);

/// Seals, as found, the end of a run that has a result but no seal of its end, as after a kill in between.
/// @returns false: there is nothing to seal
bool seal_end(const std::filesystem::path& run, const std::string& reason);

/// Seals the notes that were added after the end of a run was sealed. The caller holds the run.
/// @returns false: there are none, or the newest incarnation is not sealed yet
/// @throws UsageError: the run is not as it was sealed
bool seal_notes(const std::filesystem::path& run);

/// Seals files that a command made from the run. Does nothing in a run without seals.
/// @param files relative to the run folder
void seal_derived(const std::filesystem::path& run, const std::vector<std::string>& files);

}  // namespace firn::runs
