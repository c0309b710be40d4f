// OwnPrint holds the lab's own programs of one print: starts and watches those of [nodes.NAME] command, and
// takes the messages that they, and others with a key, publish.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "print/own/own_door.h"
#include "print/process/child_process.h"
#include "runs/folder/run_folder.h"

namespace firn {

class OwnPrint {
 public:
  /// @param take publishes a message; @param warn reports a fault that does not stop the print; @param note
  /// tells the user
  OwnPrint(const Experiment& experiment, const runs::RunFolder& run, const std::string& bus_url,
           const std::optional<BusKey>& key, OwnDoor::Take take, OwnDoor::Warn warn,
           std::function<void(const std::string&)> note);

  /// Starts the commands. A program has on its standard input one line with its admission (own_door.h), the
  /// run folder and the configuration's file, then START, later STOP with the cause, and the end of the file
  /// when the print has ended. Its output goes to nodes/NAME.err.
  void start();
  void begin();
  void add_to(std::vector<pollfd>& fds);
  void service();
  /// Returns which needed program has ended, or has been silent for too long, and its last words; empty:
  /// none. Of others the user is told.
  std::string lost();
  /// Carries out "key NAME" and "say NAME CHANNEL JSON". @returns "ok ..." @throws UsageError
  std::string obey(const std::string& order);
  /// Tells the programs that the print is over, waits for their end, and kills those that go on.
  /// @param turn waits for a while for something to happen
  void end(const std::string& cause, const std::function<void()>& turn);
  std::vector<std::pair<std::string, pid_t>> pids() const;

 private:
  struct Program {
    std::string name;
    OwnProgram config;
    std::unique_ptr<ChildProcess> process;
    bool told = false;  // that it is gone
  };
  std::string trouble_of(Program&);
  double quiet_s(const Program&) const;

  const runs::RunFolder& run_;
  std::function<void(const std::string&)> note_;
  OwnDoor door_;
  std::vector<Program> programs_;
  std::optional<double> began_s_;  // wall time of START
};

}  // namespace firn
