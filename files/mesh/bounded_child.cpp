#include "files/mesh/bounded_child.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>

namespace firn::mesh {
namespace {

constexpr int kOutOfMemory = 97, kThrew = 98;  // exit codes of the child
constexpr unsigned kWallFactor = 10;

/// Address space of this process [byte]; a child begins with as much.
std::size_t address_space() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::size_t(pages) * std::size_t(::sysconf(_SC_PAGESIZE));
}

void bound(int what, rlim_t limit, rlim_t margin = 0) {
  rlimit before{};
  ::getrlimit(what, &before);
  const rlimit to{std::min(limit, before.rlim_max), std::min(limit + margin, before.rlim_max)};
  ::setrlimit(what, &to);
}

[[noreturn]] void child(const ChildLimits& limits, pid_t parent, int fd,
                        const std::function<void(int)>& send) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kThrew);
  // Ctrl-C is the parent's to answer; a crash must end the child without the parent's handlers.
  std::signal(SIGINT, SIG_IGN);
  for (const int s : {SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, SIGXCPU, SIGALRM, SIGPIPE})
    std::signal(s, SIG_DFL);
  bound(RLIMIT_CORE, 0);
  bound(RLIMIT_CPU, rlim_t(limits.cpu_s), 2);  // SIGXCPU first, which tells the limit from other kills
  bound(RLIMIT_AS, rlim_t(address_space() + limits.memory_bytes));
  ::alarm(kWallFactor * unsigned(limits.cpu_s));
  std::set_new_handler([] { ::_exit(kOutOfMemory); });
  try {
    send(fd);
  } catch (...) {
    ::_exit(kThrew);
  }
  ::_exit(0);
}

std::string ending(int status, const ChildLimits& limits) {
  if (WIFEXITED(status)) {
    if (WEXITSTATUS(status) == 0) return "";
    if (WEXITSTATUS(status) == kOutOfMemory)
      return fmt::format("needs more than {} MiB of memory, the limit", limits.memory_bytes >> 20);
    return fmt::format("ended with exit code {}", WEXITSTATUS(status));
  }
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (signal == SIGXCPU) return fmt::format("took more than {} s of processor time, the limit", limits.cpu_s);
  if (signal == SIGALRM)
    return fmt::format("took more than {} s, the limit", kWallFactor * unsigned(limits.cpu_s));
  return fmt::format("crashed ({})", ::strsignal(signal));
}

[[noreturn]] void fail(const char* what) {
  throw std::runtime_error(fmt::format("{}: {}", what, std::strerror(errno)));
}

}  // namespace

std::string run_bounded(const ChildLimits& limits, const std::function<void(int)>& send,
                        const std::function<void(int)>& receive) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail("no pipe for a child process");
  const pid_t parent = ::getpid(), pid = ::fork();
  if (pid < 0) {
    const int error = errno;
    ::close(ends[0]);
    ::close(ends[1]);
    errno = error;
    fail("no child process");
  }
  if (pid == 0) {
    ::close(ends[0]);
    child(limits, parent, ends[1], send);
  }
  ::close(ends[1]);
  std::exception_ptr trouble;
  try {
    receive(ends[0]);
  } catch (...) {
    trouble = std::current_exception();
  }
  ::close(ends[0]);  // a child that still writes ends by SIGPIPE
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) fail("a child process is lost");
  const bool refused = trouble && WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE;
  std::string how = refused ? "" : ending(status, limits);
  if (how.empty() && trouble) std::rethrow_exception(trouble);
  return how;
}

}  // namespace firn::mesh
