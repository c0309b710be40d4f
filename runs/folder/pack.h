// Packs the records of a run that nobody prints, and writes them plain again.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace firn::runs {

struct PackReport {
  std::uint64_t before = 0, after = 0;  ///< bytes of the files that were looked at
  bool interrupted = false;             ///< by PackWatch; the other files are as before
};

/// Follows a packing.
struct PackWatch {
  std::function<void(double fraction, const std::string& file)> progress = {};  ///< of all bytes
  std::function<bool()> interrupted = {};  ///< true ends it within a file; the file stays as it was
};

/// Packs log.lcm, write-ahead files and the world's records (files/record/packed.h); small and packed files
/// stay as they are. Every file is unpacked and compared before it takes the place of the plain one; until
/// then it is a trial file (trial_files.h). The seals hold as before: their digests are of the plain bytes.
/// May be repeated after any failure. Holds the lock of the run (run_lock.h).
/// @throws UsageError: somebody uses the run; PackedError; std::runtime_error naming a file that cannot be
/// written or read
PackReport pack_run(const std::filesystem::path& run, const PackWatch& watch = {});

/// Writes all packed files plain again, as lcm-logplayer and a resume need them. @throws as pack_run
PackReport expand_run(const std::filesystem::path& run, const PackWatch& watch = {});

/// The same for the process that holds the lock of the run: the end of a print, a resume, a repair.
PackReport pack_records(const std::filesystem::path& run, const PackWatch& watch = {});
PackReport expand_records(const std::filesystem::path& run, const PackWatch& watch = {});

/// Returns the sum of the sizes of all files of a folder.
std::uint64_t folder_bytes(const std::filesystem::path& folder);

}  // namespace firn::runs
