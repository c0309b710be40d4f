#include "procs/relay/ssh.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

extern char** environ;

namespace firn::relay {
namespace {

constexpr std::size_t kMostSaid = 4096;  // bytes of the end of its messages

}  // namespace

std::string ssh_trouble(const std::string& said, const std::string& address, const std::string& command) {
  const auto has = [&](const char* text) { return said.find(text) != std::string::npos; };
  const std::string program = command.substr(0, command.find(' '));
  const std::string last = said.empty() ? "ssh ended without a word" : "ssh says: " + said;
  if (has("Host key verification failed") || has("HOST IDENTIFICATION HAS CHANGED"))
    return last + "; its key is unknown or another than before: look why, then `ssh " + address +
           "` once by hand";
  if (has("Permission denied"))
    return last + "; `ssh " + address + "` must work without a password: ssh-copy-id " + address;
  if (has("Could not resolve hostname")) return last + "; the name in [hosts] must be one that ssh knows";
  if (has("not found") || has("No such file"))
    return last + "; install firn there (firn host --install LAB copies this one), or say where it is: \"" +
           address + ":/path/to/firn\" instead of " + program;
  if (has("timed out") || has("No route to host") || has("refused"))
    return last + "; is the computer on, and its sshd?";
  return last;
}

Ssh::Ssh(const std::string& address, const std::string& command) : address_(address), command_(command) {
  int stream[2], errors[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, stream) != 0 || ::pipe2(errors, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("a socket for ssh: ") + std::strerror(errno));
  std::string words[] = {
      "ssh", "-T",   "-o", "BatchMode=yes", "-o",   "ConnectTimeout=5", "-o", "ServerAliveInterval=5",
      "-e",  "none", "--", address,         command};
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, stream[1], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, stream[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, errors[1], STDERR_FILENO);
  posix_spawnattr_t apart;  // from the terminal, whose Ctrl-C is the launcher's, and which must not be asked
  posix_spawnattr_init(&apart);
  posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETSID);
  const int error = ::posix_spawnp(&pid_, "ssh", &files, &apart, argv.data(), environ);
  posix_spawnattr_destroy(&apart);
  posix_spawn_file_actions_destroy(&files);
  ::close(stream[1]);
  ::close(errors[1]);
  stream_ = stream[0];
  errors_ = errors[0];
  ::fcntl(errors_, F_SETFL, O_NONBLOCK);
  if (error != 0) {
    ::close(stream_);
    ::close(errors_);
    throw std::runtime_error(std::string("ssh cannot be started (package openssh-client): ") +
                             std::strerror(error));
  }
}

Ssh::~Ssh() {
  if (stream_ >= 0) ::close(stream_);
  if (errors_ >= 0) ::close(errors_);
  if (running()) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
}

int Ssh::take_stream() { return std::exchange(stream_, -1); }

void Ssh::add_to(std::vector<pollfd>& fds) const {
  if (errors_ >= 0) fds.push_back({errors_, POLLIN, 0});
}

void Ssh::service() {
  char text[1024];
  for (;;) {
    const ssize_t got = errors_ < 0 ? 0 : ::read(errors_, text, sizeof text);
    if (got == 0 && errors_ >= 0) {
      ::close(errors_);
      errors_ = -1;
    }
    if (got <= 0) return;
    (void)!::write(STDERR_FILENO, text, std::size_t(got));
    said_.append(text, std::size_t(got));
    if (said_.size() > kMostSaid) said_.erase(0, said_.size() - kMostSaid);
  }
}

bool Ssh::running() {
  int status = 0;
  if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  return !status_;
}

std::string Ssh::trouble() const {
  std::string said = said_;
  while (!said.empty() && (said.back() == '\n' || said.back() == '\r')) said.pop_back();
  const std::size_t line = said.rfind('\n');
  const bool changed = said.find("HOST IDENTIFICATION HAS CHANGED") != std::string::npos;
  if (line != std::string::npos && !changed) said.erase(0, line + 1);
  if (changed) said = "the key of the host has changed (REMOTE HOST IDENTIFICATION HAS CHANGED)";
  return ssh_trouble(said, address_, command_);
}

}  // namespace firn::relay
