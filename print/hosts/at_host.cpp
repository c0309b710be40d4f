#include "print/hosts/at_host.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "config/devices.h"
#include "core/options/number.h"
#include "files/command.h"
#include "files/exit_codes.h"
#include "files/temporary_folder.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "procs/relay/hello.h"
#include "procs/relay/ssh.h"

extern char** environ;

namespace firn {
namespace {

namespace fs = std::filesystem;

std::string hex_of(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const unsigned char c : text) {
    hex += kDigits[c >> 4];
    hex += kDigits[c & 15];
  }
  return hex;
}

/// @param output takes its words, if it is not null
/// @param each_turn called every 50 ms until it has ended
int run_words(std::vector<std::string> words, std::string* output,
              const std::function<void(pid_t)>& each_turn = {}) {
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  int pipe[2] = {-1, -1};
  if (output && ::pipe2(pipe, O_CLOEXEC) != 0) throw std::runtime_error(std::strerror(errno));
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  if (output) posix_spawn_file_actions_adddup2(&files, pipe[1], STDOUT_FILENO);
  pid_t pid = -1;
  const int error = ::posix_spawnp(&pid, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (output) ::close(pipe[1]);
  if (error != 0) {
    if (output) ::close(pipe[0]);
    throw std::runtime_error(words[0] + ": cannot be started: " + std::strerror(error));
  }
  if (output) {
    char buffer[4096];
    for (ssize_t got = 0; (got = ::read(pipe[0], buffer, sizeof buffer)) > 0 || (got < 0 && errno == EINTR);)
      if (got > 0) output->append(buffer, std::size_t(got));
    ::close(pipe[0]);
  }
  int status = 0;
  for (pid_t ended = 0; ended != pid;) {
    ended = ::waitpid(pid, &status, each_turn ? WNOHANG : 0);
    if (ended < 0 && errno != EINTR) break;
    if (ended != 0) continue;
    each_turn(pid);
    ::poll(nullptr, 0, 50);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kFailed;
}

/// Nobody reads this process's words: ssh has gone.
bool output_is_closed() {
  pollfd out{STDOUT_FILENO, 0, 0};
  return ::poll(&out, 1, 0) > 0 && (out.revents & (POLLERR | POLLHUP)) != 0;
}

std::string text_in(std::string_view hex, const char* option) {
  std::string text;
  for (std::size_t n = 0; n < hex.size(); n += 2) {
    const auto byte = hex_byte(hex.substr(n, 2));
    if (!byte)
      throw UsageError(std::string(option) + ": byte " + std::to_string(n) + " is no hexadecimal digit");
    text += char(*byte);
  }
  return text;
}

}  // namespace

std::string host_of(const Experiment& lab, const std::string& node) {
  const auto at = lab.hosts.of_node.find(node);
  return at == lab.hosts.of_node.end() ? "" : at->second;
}

std::vector<std::string> words_at_host(const Experiment& lab, const std::string& host,
                                       const std::string& command, const std::vector<std::string>& words,
                                       const std::vector<FileOfLab>& files, bool person) {
  Experiment there =
      lab;  // as that computer sees it: instruments that are elsewhere are none of its business
  for (const DevicePort& port : kDevicePorts)
    if (host_of(lab, std::string(port.node)) != host) there.devices.*port.member = "sim:";
  there.hosts = {};
  const relay::HostPlace place = relay::place_of(lab.hosts.address.at(host));
  std::string line = shell_word(place.program) + " host --lab " + hex_of(dump(there));
  for (const FileOfLab& f : files) line += " --file " + shell_word(f.name) + ":" + hex_of(f.text);
  line += " -- " + command;
  for (const std::string& w : words) line += " " + shell_word(w);
  return {"ssh", person ? "-t" : "-T", "-o", "ConnectTimeout=5", "--", place.address, line};
}

int run_at_host(const Experiment& lab, const std::string& host, const std::string& command,
                const std::vector<std::string>& words, const std::vector<FileOfLab>& files,
                std::string* output) {
  const bool person = !output && ::isatty(STDIN_FILENO) && ::isatty(STDOUT_FILENO);
  const int status = run_words(words_at_host(lab, host, command, words, files, person), output);
  if (status != relay::kSshFailed) return status;
  std::fprintf(stderr, "host %s (%s) cannot be reached by ssh; docs/hosts.md\n", host.c_str(),
               lab.hosts.address.at(host).c_str());
  return kSafetyStop;
}

int run_here(const std::string& lab_in_hex, const std::vector<std::string>& files_in_hex,
             const std::string& command, const std::vector<std::string>& words) {
  const std::string text = text_in(lab_in_hex, "--lab");
  std::vector<FileOfLab> files;
  for (const std::string& f : files_in_hex) {
    const std::size_t colon = f.find(':');
    if (colon == f.npos || fs::path(f.substr(0, colon)).filename() != f.substr(0, colon))
      throw UsageError("--file: wanted is NAME:DIGITS");
    files.push_back({f.substr(0, colon), text_in(std::string_view(f).substr(colon + 1), "--file")});
  }
  const TemporaryFolder folder("lab");
  const fs::path file = folder / "lab.toml";
  write_file_atomically(file, text);
  for (const FileOfLab& f : files) write_file_atomically(folder / f.name, f.text);
  std::vector<std::string> all{fs::read_symlink("/proc/self/exe").string(), command};
  bool named = false;
  for (const std::string& w : words) {
    named = named || w == kLabHere;
    all.push_back(w == kLabHere ? file.string() : w);
  }
  if (!named) all.insert(all.begin() + 2, file.string());
  bool told = false;
  return run_words(all, nullptr, [&](pid_t pid) {
    if (!told && output_is_closed()) {
      told = true;
      ::kill(pid, SIGINT);
    }
  });
}

}  // namespace firn
