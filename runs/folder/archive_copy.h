// Copies sealed runs into an archive by rsync: a folder of this computer, or one of another computer by ssh.
// A copy is a run there only once it was verified.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace firn::runs {

struct ArchiveCopy {
  enum class State : std::uint8_t { kCopied, kRenewed, kThere, kLeftOut };
  State state = State::kLeftOut;
  std::string why;     ///< of kLeftOut
  std::string digest;  ///< of the newest seal, else
};

/// The folder that copies go to. A copy of NAME arrives in .arriving-NAME and takes its name when it is kept.
class Archive {
 public:
  Archive() = default;
  virtual ~Archive() = default;
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  /// Returns a folder with seals, notes and provenance of the run NAME that is there; empty: there is no
  /// NAME.
  virtual std::filesystem::path look(const std::string& name) = 0;
  /// Sends a run's files, as far as they are not there. @param renews a run NAME is there already
  /// @param thorough compares contents, not sizes and times @param stop ends rsync; the copy goes on the next
  /// time @throws UsageError: rsync is not installed; std::runtime_error naming file and reason
  virtual void send(const std::filesystem::path& run, const std::string& name, bool renews, bool thorough,
                    const std::atomic<bool>* stop) = 0;
  /// Reads the copy. @returns why it is not the run as it was sealed; empty: it is
  /// @param digest of the newest seal
  virtual std::string verify(const std::filesystem::path& run, const std::string& name,
                             const std::string& digest, const std::atomic<bool>* stop) = 0;
  /// Gives the copy its name. @param renews it takes the place of the run that is there
  virtual void keep(const std::string& name, bool renews) = 0;
};

/// A folder of this computer, held for one process that copies into it; the system gives it back when the
/// process ends.
class FolderArchive : public Archive {
 public:
  /// Makes the folder where it is missing. @throws UsageError: another process copies into it, or no folder
  /// can be made there
  explicit FolderArchive(const std::filesystem::path& archive);
  ~FolderArchive() override;

  std::filesystem::path look(const std::string& name) override;
  void send(const std::filesystem::path& run, const std::string& name, bool renews, bool thorough,
            const std::atomic<bool>* stop) override;
  std::string verify(const std::filesystem::path& run, const std::string& name, const std::string& digest,
                     const std::atomic<bool>* stop) override;
  void keep(const std::string& name, bool renews) override;

 private:
  std::filesystem::path archive_;
  int folder_ = -1;
};

/// Copies a run to ARCHIVE/NAME. Notes that no seal covers yet are sealed first. The copy goes on if it was
/// cut off before, and takes its name when its files are those of the seals. A run that is not sealed, or not
/// as it was sealed, stays; so does one whose name another run has.
/// @param stop ends rsync; the copy goes on the next time
/// @throws UsageError: rsync is not installed, the run is in use; std::runtime_error naming file and reason
ArchiveCopy copy_to_archive(const std::filesystem::path& run, Archive& archive,
                            const std::atomic<bool>* stop = nullptr);

/// Calls rsync for the files of a run. @param how further options @param from, to folders, with a '/' at the
/// end @returns its standard output
/// @throws UsageError: it is not installed; std::runtime_error naming `from` and its reason
std::string rsync_run(const std::vector<std::string>& how, const std::string& from, const std::string& to,
                      const std::atomic<bool>* stop);

}  // namespace firn::runs
