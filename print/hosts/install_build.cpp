#include "print/hosts/install_build.h"

#include <algorithm>
#include <array>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "files/command.h"
#include "files/digest.h"
#include "files/temporary_folder.h"
#include "files/text_file.h"
#include "lcmtypes/channels.h"
#include "procs/relay/file_stream.h"
#include "procs/relay/ssh.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kDigestDigits = 12;

// Files that a process of a print needs at a host (runtime/build_info.h has all of it in its digest).
std::vector<std::string> files_of(const fs::path& home) {
  std::vector<std::string> names{"bin/firn", "bin/relay", "bin/world", "bin/recorder", "bin/page"};
  for (const NodeInfo& n : nodes()) names.push_back("bin/" + std::string(n.name));
  for (const char* plugins : {"python", "pictures"}) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(home / plugins, none))
      if (entry.path().extension() == ".so") names.push_back(fs::relative(entry.path(), home).string());
  }
  std::erase_if(names, [&](const std::string& name) { return !fs::is_regular_file(home / name); });
  std::ranges::sort(names);
  return names;
}

// Its input is the archive. Nothing has the build's name before it is whole and has run.
std::string script(const std::string& build) {
  return "set -e\n"
         "home=${XDG_DATA_HOME:-$HOME/.local/share}/firn\n"
         "new=$home/builds/" +
         build +
         "\n"
         "part=$new.part-$$\n"
         "trap 'rm -rf \"$part\"' EXIT\n"
         "mkdir -p \"$part\"\n"
         "tar -x -C \"$part\"\n"
         "(cd \"$part\" && sha256sum --quiet -c sums >&2)\n"
         "name=$(\"$part/bin/firn\" --version)\n"
         "if ! (cd \"$new\" && cmp -s sums \"$part/sums\" && sha256sum --status -c sums) 2> /dev/null; then\n"
         "  rm -rf \"$new\"\n"
         "  mv -T \"$part\" \"$new\"\n"
         "fi\n"
         "ln -s \"builds/" +
         build +
         "\" \"$home/current.$$\"\n"
         "mv -T \"$home/current.$$\" \"$home/current\"\n"
         "printf '%s\\n' \"$name\" \"$home/current/bin/firn\"\n";
}

std::string remedy(const std::string& said) {
  const auto has = [&](std::string_view text) { return said.find(text) != said.npos; };
  if (has("shared libraries")) return "; install there what the package of firn depends on: docs/packages.md";
  if (has("Exec format error")) return "; that computer has another kind of processor: build firn there";
  if (has("GLIBC_") || has("GLIBCXX_"))
    return "; that computer has an older system than the one that built this firn: build firn there";
  if (has("No space left")) return "; make room there";
  if (has("Permission denied")) return "; the folder must be the user's own";
  return "";
}

}  // namespace

std::string build_folder_name() { return build_version() + "-" + build_sources().substr(0, kDigestDigits); }

InstalledBuild install_build(const std::string& address, const fs::path& home) {
  const std::vector<std::string> names = files_of(home);
  std::string sums;
  for (const std::string& name : names) sums += relay::state_of(home / name).sha256 + "  " + name + "\n";
  const TemporaryFolder folder("install");
  write_file_atomically(folder / "sums", sums);
  std::string line =
      "tar -c -h -C " + shell_word((folder / "").string()) + " sums -C " + shell_word(home.string());
  for (const std::string& name : names) line += " " + shell_word(name);
  const std::string there = "sh -c " + shell_word(script(build_folder_name()));
  line +=
      " | ssh -T -C -o BatchMode=yes -o ConnectTimeout=5 -- " + shell_word(address) + " " + shell_word(there);
  const CommandEnd end = run_command({"sh", "-c", line});
  if (end.code == relay::kSshFailed)
    throw std::runtime_error("cannot be reached: " + relay::ssh_trouble(end.reason(), address, "firn host"));
  std::istringstream said(end.output);
  InstalledBuild build;
  if (end.code != 0 || !std::getline(said, build.name) || !std::getline(said, build.program))
    throw std::runtime_error("does not take this build of firn: " + end.reason() + remedy(end.errors));
  return build;
}

}  // namespace firn
