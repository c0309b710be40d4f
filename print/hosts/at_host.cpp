#include "print/hosts/at_host.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include "config/devices.h"
#include "core/options/number.h"
#include "files/command.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "procs/relay/hello.h"

extern char** environ;

namespace firn {
namespace {

namespace fs = std::filesystem;
constexpr int kSshFailed = 255;

std::string hex_of(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const unsigned char c : text) {
    hex += kDigits[c >> 4];
    hex += kDigits[c & 15];
  }
  return hex;
}

int run_words(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  pid_t pid = -1;
  if (const int error = ::posix_spawnp(&pid, argv[0], nullptr, nullptr, argv.data(), environ); error != 0)
    throw std::runtime_error(words[0] + ": cannot be started: " + std::strerror(error));
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

}  // namespace

std::string host_of(const Experiment& lab, const std::string& node) {
  const auto at = lab.hosts.of_node.find(node);
  return at == lab.hosts.of_node.end() ? "" : at->second;
}

std::vector<std::string> words_at_host(const Experiment& lab, const std::string& host,
                                       const std::string& command, const std::vector<std::string>& words) {
  Experiment there =
      lab;  // as that computer sees it: instruments that are elsewhere are none of its business
  for (const DevicePort& port : kDevicePorts)
    if (host_of(lab, std::string(port.node)) != host) there.devices.*port.member = "sim:";
  there.hosts = {};
  const relay::HostPlace place = relay::place_of(lab.hosts.address.at(host));
  std::string line = shell_word(place.program) + " host --lab " + hex_of(dump(there)) + " -- " + command;
  for (const std::string& w : words) line += " " + shell_word(w);
  const bool person = ::isatty(STDIN_FILENO) && ::isatty(STDOUT_FILENO);
  return {"ssh", person ? "-t" : "-T", "-o", "ConnectTimeout=5", "--", place.address, line};
}

int run_at_host(const Experiment& lab, const std::string& host, const std::string& command,
                const std::vector<std::string>& words) {
  const int status = run_words(words_at_host(lab, host, command, words));
  if (status != kSshFailed) return status;
  std::fprintf(stderr, "host %s (%s) cannot be reached by ssh; docs/hosts.md\n", host.c_str(),
               lab.hosts.address.at(host).c_str());
  return kSafetyStop;
}

int run_here(const std::string& lab_in_hex, const std::string& command,
             const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t n = 0; n < lab_in_hex.size(); n += 2) {
    const auto byte = hex_byte(std::string_view(lab_in_hex).substr(n, 2));
    if (!byte) throw UsageError("--lab: byte " + std::to_string(n) + " is no hexadecimal digit");
    text += char(*byte);
  }
  std::string folder = (fs::temp_directory_path() / "firn-lab-XXXXXX").string();
  if (!::mkdtemp(folder.data())) throw std::runtime_error(folder + ": " + std::strerror(errno));
  const fs::path file = fs::path(folder) / "lab.toml";
  write_file_atomically(file, text);
  std::vector<std::string> all{fs::read_symlink("/proc/self/exe").string(), command, file.string()};
  all.insert(all.end(), words.begin(), words.end());
  const int status = run_words(all);
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return status;
}

}  // namespace firn
