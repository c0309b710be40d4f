// install_build() copies this build of firn to another computer by ssh, into the user's own folder there: no
// right of root is needed on either side.
#pragma once

#include <filesystem>
#include <string>

namespace firn {

struct InstalledBuild {
  std::string program;  ///< firn there, an absolute path that the next installation keeps
  std::string name;     ///< as `firn --version` says it there
};

/// Returns "VERSION-DIGEST", which names the folder of a build.
std::string build_folder_name();

/// Copies the programs, and the plug-ins for Python and pictures, into
/// "$XDG_DATA_HOME/firn/builds/VERSION-DIGEST" of the other computer ("~/.local/share/firn/…"), and lets
/// "$XDG_DATA_HOME/firn/current" point to it. Each file is compared by its SHA-256 there, and the program is
/// started once, before the folder has its name; a copy that is there and sound stays as it is.
/// @param address as ssh has it @param home of this build: its programs are in home/bin
/// @throws std::runtime_error why it cannot be had there, and the remedy; the build before it stays
InstalledBuild install_build(const std::string& address, const std::filesystem::path& home);

}  // namespace firn
