// ChildProcess holds one process of a run on this computer: started with a control line, watched by a pidfd,
// ended for certain.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "print/process/node_process.h"
#include "runtime/control_line.h"

namespace firn {

class ChildProcess : public NodeProcess {
 public:
  /// Whether processes that this one starts end with it: they do in a group of their own.
  enum class Group : std::uint8_t { kOfLauncher, kOwn };

  /// Starts `program` with `arguments`; the control line is descriptor kControlFd there. stderr goes to the
  /// end of `stderr_file`. @throws std::runtime_error naming the program
  ChildProcess(std::string name, const std::filesystem::path& program,
               const std::vector<std::string>& arguments, const std::filesystem::path& stderr_file,
               Group group = Group::kOfLauncher);
  /// Kills the process if it still runs.
  ~ChildProcess() override;

  static constexpr int kControlFd = 3;

  ControlLine& control() { return control_; }
  pid_t pid() const override { return pid_; }
  void say(std::string_view line) override { control_.say(line); }
  std::optional<std::string> next() override { return control_.next(); }
  void add_to(std::vector<pollfd>& fds) override;
  const std::optional<Ending>& poll_ending() override;
  void kill() override;
  /// Sends a signal, to a group of its own as a whole.
  void signal(int number);

 private:
  ControlLine control_;
  pid_t pid_ = -1;
  Group group_;
  int pidfd_ = -1;  // readable when the process has ended
  std::optional<Ending> ending_;
};

}  // namespace firn
