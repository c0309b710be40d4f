// Copies sealed runs into an archive by rsync. A copy is a run there only once its seals were checked.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>

namespace firn::runs {

struct ArchiveCopy {
  enum class State : std::uint8_t { kCopied, kRenewed, kThere, kLeftOut };
  State state = State::kLeftOut;
  std::string why;     ///< of kLeftOut
  std::string digest;  ///< of the newest seal, else
};

/// Holds an archive for one process that copies into it; the system gives it back when the process ends.
class ArchiveLock {
 public:
  /// Makes the folder where it is missing. @throws UsageError: another process copies into it, or no folder
  /// can be made there
  explicit ArchiveLock(const std::filesystem::path& archive);
  ~ArchiveLock();
  ArchiveLock(const ArchiveLock&) = delete;
  ArchiveLock& operator=(const ArchiveLock&) = delete;

  const std::filesystem::path& archive() const { return archive_; }

 private:
  std::filesystem::path archive_;
  int folder_ = -1;
};

/// Copies a run to ARCHIVE/NAME. Notes that no seal covers yet are sealed first. The copy arrives in
/// ARCHIVE/.arriving-NAME, goes on there if it was cut off before, and takes its name when its files are
/// those of the seals. A run that is not sealed, or not as it was sealed, stays; so does one whose name
/// another run has.
/// @param stop ends rsync; the copy goes on the next time
/// @throws UsageError: rsync is not installed, the run is in use; std::runtime_error naming file and reason
ArchiveCopy copy_to_archive(const std::filesystem::path& run, const ArchiveLock& archive,
                            const std::atomic<bool>* stop = nullptr);

}  // namespace firn::runs
