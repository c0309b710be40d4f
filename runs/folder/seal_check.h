// The seals of a run folder, RUN/seals/<n>.seal: one when an incarnation begins and one when it ends, each
// with the digest of the seal before.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "runs/folder/seal.h"

namespace firn::runs {

inline constexpr const char* kDerivedSeal =
    "derived.seal";                                    ///< of files made from the run, beside the others
inline constexpr const char* kAsFound = ", as found";  ///< end of a seal's reason: made later

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
  std::vector<SealDifference> derived;    ///< of files that commands made from the run, as metrics.csv
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
/// @throws UsageError: no such folder; std::runtime_error naming a file that cannot be read
SealCheck check_seals(const std::filesystem::path& run, bool sync = false);

/// Refuses a run that differs from its seals.
/// @param unsealed the user wants it nevertheless
/// @returns lines that mark the output: differences, parts without a seal
/// @throws UsageError naming the first difference and the number of others
std::vector<std::string> require_seals(const std::filesystem::path& run, bool unsealed);

}  // namespace firn::runs
