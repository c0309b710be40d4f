// FarArchive is a folder of another computer that copies of runs go to, by rsync over ssh. That computer
// needs sshd, rsync and a POSIX shell, and no Firn.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "files/temporary_folder.h"
#include "runs/folder/archive_copy.h"

namespace firn::runs {

/// The address of an archive on another computer, as ssh and rsync write it: "USER@HOST:PATH".
struct FarPlace {
  std::string host;  ///< as ssh takes it, also of its configuration
  std::string path;  ///< full, or below the home folder
};
/// Returns nothing for a folder of this computer: a word without a colon, or with a '/' before it.
/// @throws UsageError: a host or a path that is empty or begins with '-'
std::optional<FarPlace> far_place(const std::string& word);

class FarArchive : public Archive {
 public:
  /// Makes the folder where it is missing. All calls share one connection. ssh asks nobody: keys must let it
  /// in. @throws UsageError: ssh or rsync is not installed, the host cannot be reached or no folder made
  explicit FarArchive(FarPlace place);
  ~FarArchive() override;

  /// Copies seals, notes and documents alone.
  std::filesystem::path look(const std::string& name) override;
  void send(const std::filesystem::path& run, const std::string& name, bool renews, bool thorough,
            const std::atomic<bool>* stop) override;
  /// Lets that computer read every byte again and compare its checksum (rsync --checksum).
  std::string verify(const std::filesystem::path& run, const std::string& name, const std::string& digest,
                     const std::atomic<bool>* stop) override;
  void keep(const std::string& name, bool renews) override;

 private:
  std::string there(const std::string& command) const;
  std::string folder(const std::string& name) const;

  FarPlace place_;
  TemporaryFolder scratch_;  // of this computer: the connection's socket, and files that look() has copied
  std::set<std::string> names_;  // that are there
};

}  // namespace firn::runs
