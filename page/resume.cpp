#include "page/resume.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "files/run_paths.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "runs/folder/documents.h"
#include "runs/folder/origin.h"
#include "runs/folder/running.h"

namespace firn::page {
namespace {

namespace fs = std::filesystem;

constexpr int kPatienceMs = 60'000;                // until the print takes orders
constexpr std::size_t kMostOutputBytes = 1 << 16;  // of the program, the last ones

/// The reading end of what a program writes.
struct Output {
  Output() {
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  }
  ~Output() {
    ::close(ends[0]);
    close_writing();
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  void close_writing() {
    if (ends[1] >= 0) ::close(ends[1]);
    ends[1] = -1;
  }
  int ends[2] = {-1, -1};
};

// The page ignores some signals and `firn view` blocks others; a print does neither. Connections of browsers
// stay here: boost.asio accepts them without the flag that closes them.
pid_t spawn(const fs::path& program, const std::vector<std::string>& words, int output) {
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawnattr_t how;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  posix_spawnattr_init(&how);
  sigset_t none, usual;
  sigemptyset(&none);
  sigemptyset(&usual);
  for (const int signal : {SIGINT, SIGHUP, SIGPIPE, SIGTSTP, SIGTERM}) sigaddset(&usual, signal);
  posix_spawnattr_setsigmask(&how, &none);
  posix_spawnattr_setsigdefault(&how, &usual);
  posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  pid_t pid = -1;
  const int error = ::posix_spawn(&pid, program.c_str(), &files, &how, argv.data(), environ);
  posix_spawnattr_destroy(&how);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw std::runtime_error(program.string() + ": cannot be started: " + std::strerror(error));
  return pid;
}

/// Reads to the end of the output. @returns false: the end did not come in time
bool read_all(int fd, std::string& text) {
  std::array<char, 4096> some;
  for (pollfd readable{fd, POLLIN, 0};;) {
    const int ready = ::poll(&readable, 1, kPatienceMs);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t n = ::read(fd, some.data(), some.size());
    if (n <= 0) return true;
    text.append(some.data(), std::size_t(n));
    if (text.size() > kMostOutputBytes) text.erase(0, text.size() - kMostOutputBytes);
  }
}

std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

}  // namespace

std::string resume_refusal(const fs::path& run) try {
  if (runs::printing_process(run)) return "the run is being printed";
  const fs::path file = RunPaths(run).result_path();
  if (fs::exists(file)) {
    const runs::RunResult result = runs::parse_result(read_file(file), RunPaths::kResult);
    if (!runs::can_go_on(result)) return "the run is over: " + result.outcome;
  }
  runs::require_own_resume(run, false);
  return "";
} catch (const std::exception& e) {
  return e.what();
}

std::optional<pid_t> resume_detached(const fs::path& program, const fs::path& run) {
  Output output;
  const pid_t pid = spawn(program, {"print", "--resume", run.string(), "--detach"}, output.ends[1]);
  output.close_writing();
  std::string text;
  if (!read_all(output.ends[0], text))
    throw std::runtime_error("the print takes no orders yet; " + (run / "print.out").string() +
                             " has what it says");
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(text.empty() ? "firn print ended without a word" : last_line(text));
  return runs::printing_process(run);
}

fs::path firn_beside() { return fs::read_symlink("/proc/self/exe").parent_path() / "firn"; }

}  // namespace firn::page
