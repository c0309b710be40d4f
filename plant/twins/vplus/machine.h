// Machine executes V+ programs as a controller does: tasks that share the statements of a tick of 16 ms,
// reals of 32 bits, one TCP device, and an arm behind RobotPort. A statement that fails stops its task and
// names file and line, as V+ does on its monitor.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plant/twins/vplus/controller.h"
#include "plant/twins/vplus/executor.h"

namespace firn::plant::vplus {

inline constexpr int kSlices = 16;  ///< of a tick, 1 ms each [V+ Language User's Guide]
inline constexpr std::int64_t kNeverRuns = INT64_MAX;

class Machine {
 public:
  /// @param code outlives the machine
  Machine(const Code& code, RobotPort& robot, const MachineOptions& options);
  Machine(const Machine&) = delete;

  /// Starts a program without arguments, as the monitor's EXECUTE does.
  /// @throws std::invalid_argument for a name that no program has
  void execute(std::size_t task, const std::string& program, std::int64_t now_us);
  void set(const std::string& global, float value);
  /// @returns an undefined value for a name that no program uses
  Value get(const std::string& global) const;

  /// World time of the next slice in which a statement can be executed; kNeverRuns: no task runs.
  std::int64_t next_us() const;
  void slice(std::int64_t now_us);     ///< executes one slice. @pre now_us == next_us()
  void happened(std::int64_t now_us);  ///< something outside did: a wait may be over
  /// An error of the arm reaches the task that has attached it, with REACTE or as its end.
  void arm_error(int code);

  TcpServer& network() { return c_.network; }
  /// Lines that WRITE has sent since they were taken last.
  std::vector<std::string> take_written();
  const std::vector<std::string>& typed() const { return c_.typed; }  ///< by TYPE: the last 100
  bool runs(std::size_t task) const { return c_.tasks.at(task).runs; }
  /// Returns the error that stopped a task, "file:line: reason"; else "".
  const std::string& stopped_by(std::size_t task) const { return c_.tasks.at(task).stopped_by; }
  std::uint64_t statements() const { return c_.statements; }  ///< executed so far
  std::int32_t monitor_percent() const { return c_.monitor_percent; }

  void io(Archive& a) { c_.io(a); }

 private:
  std::int64_t index_after(std::int64_t t_us) const;
  std::int64_t time_of(std::int64_t index) const;
  bool ready(const Task& task) const;
  void run_task(std::size_t task, std::int64_t& budget);
  void fail(Task& task, const Trouble& trouble);

  Controller c_;
  Executor executor_;
};

}  // namespace firn::plant::vplus
