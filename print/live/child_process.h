// ChildProcess holds one process of a run: started with a control line, watched by a pidfd, ended for
// certain.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/control_line.h"

namespace firn {

/// Holds the end of a process: exit code or signal.
struct Ending {
  int code = -1;  ///< exit code; -1 = killed
  int signal = 0;
};
/// Returns "was killed by signal 9", "exited with code 3".
std::string to_text(const Ending& ending);

class ChildProcess {
 public:
  /// Starts `program` with `arguments`; the control line is descriptor kControlFd there. stderr goes to the
  /// end of `stderr_file`. @throws std::runtime_error naming the program
  ChildProcess(std::string name, const std::filesystem::path& program,
               const std::vector<std::string>& arguments, const std::filesystem::path& stderr_file);
  /// Kills the process if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  static constexpr int kControlFd = 3;

  const std::string& name() const { return name_; }
  pid_t pid() const { return pid_; }
  int pidfd() const { return pidfd_; }  ///< readable when the process has ended
  ControlLine& control() { return control_; }
  /// Returns the ending once the process has ended; the same ending in all later calls.
  const std::optional<Ending>& poll_ending();
  bool running() { return !poll_ending(); }
  void kill();

 private:
  std::string name_;
  ControlLine control_;
  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::optional<Ending> ending_;
};

}  // namespace firn
