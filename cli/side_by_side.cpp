#include "cli/side_by_side.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "cli/failure.h"
#include "files/json.h"
#include "print/interrupt.h"

namespace firn {
namespace {

std::string summary_text(const PrintSummary& s) {
  return nlohmann::json{{"folder", s.folder},
                        {"scheme", s.scheme},
                        {"result", runs::result_text(s.result)},
                        {"droplets", s.droplets},
                        {"wall_s", s.wall_s}}
      .dump();
}

PrintSummary parse_summary(const std::string& text) {
  const auto j = nlohmann::json::parse(text);
  PrintSummary s;
  s.folder = j.at("folder");
  s.scheme = j.at("scheme");
  s.result = runs::parse_result(j.at("result").get<std::string>(), "summary");
  s.droplets = j.at("droplets");
  s.wall_s = j.at("wall_s");
  return s;
}

void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(std::size_t(n));
  }
}

/// A pipe, and the text that came out of it.
struct Pipe {
  Pipe() {
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("pipe: ") + std::strerror(errno));
  }
  ~Pipe() {
    for (const int end : ends)
      if (end >= 0) ::close(end);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close(int end) { ::close(std::exchange(ends[end], -1)); }
  /// Reads all available bytes; false at the end.
  bool read() {
    char bytes[4096];
    const ssize_t n = ::read(ends[0], bytes, sizeof bytes);
    if (n < 0 && errno == EINTR) return true;
    if (n <= 0) return false;
    text.append(bytes, std::size_t(n));
    return true;
  }

  int ends[2];
  std::string text;
};

/// A print and its output until now.
struct Child {
  pid_t pid = -1;
  Pipe lines, summary;
};

[[noreturn]] void be_child(Child& child, const LivePrint& print, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // nobody waits any more: the lab is made safe
  if (::getppid() != parent) ::_exit(1);
  ::dup2(child.lines.ends[1], STDERR_FILENO);
  child.lines.close(1);
  int code = 0;
  try {
    write_all(child.summary.ends[1], summary_text(print.carry_out()));
  } catch (const std::exception& e) {
    const Failure f = failure_of(e);
    std::fprintf(stderr, "%s: %s\n", print.title.c_str(), f.line.c_str());
    code = f.code;
  }
  std::fflush(nullptr);
  ::_exit(code);
}

// Whole lines, so that those of two prints do not mix.
void pass_lines(Pipe& from, bool all) {
  const std::size_t end = all ? from.text.size() : from.text.rfind('\n') + 1;
  write_all(STDERR_FILENO, std::string_view(from.text).substr(0, end));
  from.text.erase(0, end);
}

void watch(std::vector<Child>& children) {
  const InterruptGuard guard;
  bool told = false;
  for (;;) {
    std::vector<pollfd> open;
    std::vector<Pipe*> pipes;
    for (Child& child : children)
      for (Pipe* pipe : {&child.lines, &child.summary})
        if (pipe->ends[0] >= 0) {
          open.push_back({pipe->ends[0], POLLIN, 0});
          pipes.push_back(pipe);
        }
    if (open.empty()) return;
    ::poll(open.data(), nfds_t(open.size()), 500);
    if (InterruptGuard::raised() && !std::exchange(told, true))
      for (const Child& child : children) ::kill(child.pid, SIGTERM);
    for (std::size_t n = 0; n < open.size(); ++n) {
      if (open[n].revents == 0) continue;
      if (!pipes[n]->read()) pipes[n]->close(0);
    }
    for (Child& child : children) pass_lines(child.lines, child.lines.ends[0] < 0);
  }
}

}  // namespace

std::vector<PrintSummary> print_side_by_side(const std::vector<LivePrint>& prints) {
  std::vector<Child> children(prints.size());
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  for (std::size_t n = 0; n < prints.size(); ++n) {
    children[n].pid = ::fork();
    if (children[n].pid < 0) throw std::runtime_error(std::string("fork: ") + std::strerror(errno));
    if (children[n].pid == 0) be_child(children[n], prints[n], parent);
    children[n].lines.close(1);
    children[n].summary.close(1);
  }
  watch(children);
  for (const Child& child : children)
    while (::waitpid(child.pid, nullptr, 0) < 0 && errno == EINTR) {
    }
  std::vector<PrintSummary> summaries;
  for (std::size_t n = 0; n < prints.size(); ++n) {
    if (children[n].summary.text.empty())
      throw std::runtime_error(prints[n].title + " ended without a result");
    summaries.push_back(parse_summary(children[n].summary.text));
  }
  return summaries;
}

}  // namespace firn
