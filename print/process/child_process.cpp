#include "print/process/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

extern char** environ;

namespace firn {
namespace {

struct FileActions {
  posix_spawn_file_actions_t actions;
  FileActions() { posix_spawn_file_actions_init(&actions); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions); }
};

struct Attributes {
  posix_spawnattr_t attributes;
  Attributes() { posix_spawnattr_init(&attributes); }
  ~Attributes() { posix_spawnattr_destroy(&attributes); }
};

}  // namespace

std::string to_text(const Ending& e) {
  if (e.code < 0 && e.signal == 0) return "is on a host that is lost";
  return e.code < 0 ? "was killed by signal " + std::to_string(e.signal)
                    : "exited with code " + std::to_string(e.code);
}

ChildProcess::ChildProcess(std::string name, const std::filesystem::path& program,
                           const std::vector<std::string>& arguments,
                           const std::filesystem::path& stderr_file, Group group)
    : NodeProcess(std::move(name)), control_(-1), group_(group) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0)
    throw std::runtime_error("socketpair: " + std::string(std::strerror(errno)));
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  FileActions files;
  posix_spawn_file_actions_addopen(&files.actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files.actions, STDERR_FILENO, stderr_file.c_str(),
                                   O_WRONLY | O_CREAT | O_APPEND, 0644);
  posix_spawn_file_actions_adddup2(&files.actions, STDERR_FILENO, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files.actions, pair[1], kControlFd);
  Attributes how;
  if (group == Group::kOwn) posix_spawnattr_setflags(&how.attributes, POSIX_SPAWN_SETPGROUP);
  const int error =
      ::posix_spawn(&pid_, program.c_str(), &files.actions, &how.attributes, argv.data(), environ);
  ::close(pair[1]);
  if (error != 0) {
    ::close(pair[0]);
    pid_ = -1;
    throw std::runtime_error(program.string() + ": cannot be started: " + std::strerror(error));
  }
  control_.take(pair[0]);
  pidfd_ = int(::syscall(SYS_pidfd_open, pid_, 0));
  if (pidfd_ >= 0) ::fcntl(pidfd_, F_SETFD, FD_CLOEXEC);
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0 && running()) {
    kill();
    ::waitpid(pid_, nullptr, 0);
  }
  if (pidfd_ >= 0) ::close(pidfd_);
}

void ChildProcess::add_to(std::vector<pollfd>& fds) {
  if (!control_.closed()) fds.push_back({control_.fd(), POLLIN, 0});
  if (running()) fds.push_back({pidfd_, POLLIN, 0});
}

const std::optional<Ending>& ChildProcess::poll_ending() {
  int status = 0;
  if (!ending_ && ::waitpid(pid_, &status, WNOHANG) == pid_)
    ending_ = WIFEXITED(status) ? Ending{WEXITSTATUS(status), 0} : Ending{-1, WTERMSIG(status)};
  return ending_;
}

void ChildProcess::kill() { signal(SIGKILL); }

void ChildProcess::signal(int number) {
  if (poll_ending()) return;
  ::kill(group_ == Group::kOwn ? -pid_ : pid_, number);
}

}  // namespace firn
