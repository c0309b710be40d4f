// The seals of a run folder, RUN/seals/<n>.seal: one when an incarnation begins and one when it ends, each
// with the digest of the seal before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "files/seal.h"

namespace firn {

/// Holds a place where the run folder is not as it was sealed.
struct SealDifference {
  std::string file;                ///< relative to the run folder
  std::uint64_t from = 0, to = 0;  ///< bytes; both 0: the file as a whole
  std::string what;                ///< "bytes 0 to 812 are not those of seal 1"
};
std::string to_text(const SealDifference& difference);

struct SealCheck {
  std::vector<Seal> seals;                ///< that can be read, by number
  std::vector<SealDifference> differs;    ///< today's differences
  std::vector<std::string> past_differs;  ///< differences that a later seal recorded
  std::vector<std::string> notes;         ///< parts of the run that no seal covers
  std::vector<SealedFile> files;          ///< as they are today

  bool whole() const { return differs.empty() && past_differs.empty(); }
  /// Returns "sealed: 2 seals, 31 files, <digest>", or "not sealed".
  std::string summary() const;
  /// Returns every difference as a line, today's first.
  std::vector<std::string> lines() const;
};

/// Compares a run folder with its seals. Files that Firn never reads from a run folder are not looked at.
/// @param sync the files reach the disk first
/// @throws std::runtime_error naming a file that cannot be read
SealCheck check_seals(const std::filesystem::path& run, bool sync = false);

/// Refuses a run that differs from its seals.
/// @param unsealed the user wants it nevertheless
/// @returns lines that mark the output: differences, parts without a seal
/// @throws UsageError naming the first difference and the number of others
std::vector<std::string> require_seals(const std::filesystem::path& run, bool unsealed);

/// Seals an incarnation: where it begins and, with ended(), where it ends. Without ended(), as after a kill,
/// the run counts as not sealed since this incarnation began. Holds a lock: one process at a time prints a
/// run.
class SealedIncarnation {
 public:
  /// @param resume the folder is compared with its seals first
  /// @param unsealed resume although it differs; the seal records the differences
  /// @throws UsageError: it differs, another process prints it; std::runtime_error naming file and reason
  SealedIncarnation(const std::filesystem::path& run, std::int64_t run_id, bool resume, bool unsealed);
  ~SealedIncarnation();
  SealedIncarnation(const SealedIncarnation&) = delete;
  SealedIncarnation& operator=(const SealedIncarnation&) = delete;

  /// If the seal cannot be written, result.json is removed: the run has not ended, a resume seals it.
  /// @throws std::runtime_error naming file and reason
  void ended(const std::string& reason);

 private:
  std::filesystem::path run_;
  int lock_ = -1;
};

/// Seals a run anew whose log was repaired. Does nothing where the newest incarnation is not sealed yet.
/// @param before of the run before the repair; its differences are recorded
void seal_repaired(const std::filesystem::path& run, const SealCheck& before);

}  // namespace firn
