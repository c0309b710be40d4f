// NodeProcess is one process of a run as its launcher sees it, on this computer or on another one.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

struct pollfd;

namespace firn {

/// Holds the end of a process: exit code or signal.
struct Ending {
  int code = -1;   ///< exit code; -1 = killed
  int signal = 0;  ///< 0 with code -1: its host is lost
};
/// Returns "was killed by signal 9", "exited with code 3", "is on a host that is lost".
std::string to_text(const Ending& ending);

class NodeProcess {
 public:
  explicit NodeProcess(std::string name) : name_(std::move(name)) {}
  virtual ~NodeProcess() = default;
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  const std::string& name() const { return name_; }
  virtual pid_t pid() const = 0;
  /// Sends a line down its control line; the next line that came up (runtime/control_line.h).
  virtual void say(std::string_view line) = 0;
  virtual std::optional<std::string> next() = 0;
  /// Descriptors that are readable when it has said something or has ended.
  virtual void add_to(std::vector<pollfd>& fds) = 0;
  /// Returns the ending once the process has ended; the same ending in all later calls.
  virtual const std::optional<Ending>& poll_ending() = 0;
  virtual void kill() = 0;
  bool running() { return !poll_ending(); }

 private:
  std::string name_;
};

}  // namespace firn
