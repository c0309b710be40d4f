#include "files/command.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace firn {
namespace {

// A file in memory, which takes what a program writes.
class Sink {
 public:
  Sink() : fd_(::memfd_create("firn-command", MFD_CLOEXEC)) {
    if (fd_ < 0) throw std::runtime_error(std::string("memfd_create: ") + std::strerror(errno));
  }
  ~Sink() { ::close(fd_); }
  Sink(const Sink&) = delete;
  Sink& operator=(const Sink&) = delete;
  int fd() const { return fd_; }
  std::string text() const {
    std::string all;
    std::array<char, 1 << 16> block;
    off_t at = 0;
    while (true) {
      const ssize_t n = ::pread(fd_, block.data(), block.size(), at);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return all;
      all.append(block.data(), std::size_t(n));
      at += n;
    }
  }

 private:
  int fd_;
};

int end_of(pid_t pid) {
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

int end_of(pid_t pid, const std::atomic<bool>& stop) {
  constexpr auto kLook = std::chrono::milliseconds(20);
  constexpr int kLooksAfterTerm = 50;  // a second: GNU parallel asks for a second signal
  int looks = 0;
  for (int status = 0;; std::this_thread::sleep_for(kLook)) {
    if (::waitpid(pid, &status, WNOHANG) == pid) return status;
    if (stop && looks++ % kLooksAfterTerm == 0) ::kill(pid, SIGTERM);
  }
}

}  // namespace

std::string CommandEnd::reason() const {
  std::string said = errors.find_first_not_of(" \n\t") == std::string::npos ? output : errors;
  while (!said.empty() && std::strchr(" \n\t\r", said.back())) said.pop_back();
  const std::size_t line = said.rfind('\n');
  if (line != std::string::npos) said.erase(0, line + 1);
  return said.empty() ? "exit code " + std::to_string(code) : said;
}

CommandEnd run_command(std::vector<std::string> words, const std::atomic<bool>* stop) {
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  const Sink output, errors;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output.fd(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, errors.fd(), STDERR_FILENO);
  pid_t pid = 0;
  const int error = ::posix_spawnp(&pid, argv[0], &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error == ENOENT) return {127, "", words.front() + " is not installed"};
  if (error != 0) throw std::runtime_error(words.front() + ": cannot be started: " + std::strerror(error));
  const int status = stop ? end_of(pid, *stop) : end_of(pid);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), output.text(), errors.text()};
}

std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) || std::strchr("_-+./:=,@%", c);
  });
  if (plain) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace firn
