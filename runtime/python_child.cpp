#include "runtime/python_child.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

extern char** environ;

namespace firn {

namespace python {
extern const char kDriverProgram[];  // python/lib/firn/driver_program.py
}

namespace {

constexpr int kChannel = 3;
/// safe() of a class that holds its instrument by itself, and the program's end; beyond it the program hangs.
constexpr std::int64_t kEndsWithin_us = 1'500'000;

}  // namespace

// A program that makes its instrument safe is not waited for: it goes on alone, and ends by its own timer.
PythonChild::~PythonChild() {
  if (pid_ > 0) ::waitpid(pid_, nullptr, WNOHANG);
}

int PythonChild::start(const std::vector<std::pair<std::string, std::string>>& modules, std::string& why) {
  if (modules.empty()) {
    why = "no driver class in Python belongs to this port";
    return -1;
  }
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) {
    why = std::strerror(errno);
    return -1;
  }
  ::fcntl(pair[0], F_SETFL, O_NONBLOCK);
  std::vector<std::string> words{"python3", "-c", python::kDriverProgram};
  for (const auto& [name, file] : modules) words.push_back(name + "=" + file);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, pair[1], kChannel);
  // A session of its own: Ctrl-C is for Firn, which makes the instrument safe. Signals that a node ignores
  // are Python's own again.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t usual, none;
  sigemptyset(&usual);
  for (const int signal : {SIGPIPE, SIGHUP, SIGALRM, SIGUSR1}) sigaddset(&usual, signal);
  sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &usual);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  const int error = ::posix_spawnp(&pid_, "python3", &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  ::close(pair[1]);
  kill_at_us_ = INT64_MAX;
  if (error == 0) return pair[0];
  ::close(pair[0]);
  pid_ = -1;
  why = std::string("python3 cannot be started: ") + std::strerror(error);
  return -1;
}

void PythonChild::let_go(std::int64_t wall_us) {
  if (pid_ > 0 && kill_at_us_ == INT64_MAX) kill_at_us_ = wall_us + kEndsWithin_us;
}

bool PythonChild::ended(std::int64_t wall_us) {
  if (pid_ <= 0) return true;
  const bool late = wall_us >= kill_at_us_;
  if (late) ::kill(pid_, SIGKILL);
  const pid_t gone = ::waitpid(pid_, nullptr, late ? 0 : WNOHANG);
  if (gone == 0) return false;
  pid_ = -1;
  return true;
}

}  // namespace firn
