// Controller holds the memory of a V+ controller: tasks with their calls, variables, timers, its network
// device.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "plant/record/archive.h"
#include "plant/twins/vplus/code.h"
#include "plant/twins/vplus/robot_port.h"
#include "plant/twins/vplus/tcp_server.h"

namespace firn::plant::vplus {

inline constexpr std::size_t kTasks = 7;  ///< user tasks 0 to 6 of a C40

struct MachineOptions {
  /// Statements that all tasks together execute in 16 ms. Assumed: 0.1 ms each on a 68040 of 25 MHz; no
  /// figure is public. Range 16 to 1e6.
  int statements_per_tick = 160;
  double clock_ppm = 0.0;  ///< of the controller's clock against the world's
  int gone = kClientGone;  ///< TcpServer
  /// A task of a higher priority runs first, equal ones take turns by slices.
  std::array<int, kTasks> priorities{20, 20, 20, 20, 20, 20, 20};
};

/// A variable of the globals or of a call's locals, or one element of it.
struct Reference {
  bool global = true;
  std::uint32_t frame = 0, variable = 0;
  Element element = kScalar;
};

struct Local {
  bool is_reference = false;  ///< a parameter that stands for a variable of a caller
  Reference to;
  Variable own;
};

/// One call of a program.
struct Frame {
  std::uint32_t program = 0, at = 0;
  bool reaction = false;  ///< called by REACTE
  std::vector<Local> locals;
  std::vector<std::array<float, 2>> slots;  ///< FOR: last, step; CASE: selector
  void io(Archive& a);
};

enum class Wait : std::uint8_t { kNone, kTick, kMotion, kRest, kCalibration };

struct Task {
  bool runs = false;
  bool selected = false;  ///< SELECT ROBOT
  Wait wait = Wait::kNone;
  std::int32_t error = 0, raised = 0;  ///< its last error; one of the arm that it has still to hear of
  std::int32_t reaction = -1;          ///< program of REACTE
  float next_percent = 0.0F, percent = 100.0F, next_duration_s = -1.0F, duration_s = 0.0F;
  std::string stopped_by;
  std::vector<Frame> frames;
  void io(Archive& a);
};

/// An error of V+: its number and its text for people.
struct Trouble {
  int code;
  std::string what;
};

struct Controller {
  Controller(const Code& text, RobotPort& arm, const MachineOptions& o)
      : code(text), robot(arm), options(o), network(o.gone), globals(text.global_types.size()) {}

  double clock() const { return 1.0 + options.clock_ppm * 1e-6; }
  Frame frame_of(std::uint32_t program) const;
  void start(Task& task, std::uint32_t program) const;
  /// @throws std::runtime_error for a damaged state, or one of another text
  void io(Archive& a);

  const Code& code;
  RobotPort& robot;
  MachineOptions options;
  TcpServer network;
  std::int64_t now_us = 0, slice = 0, elements = 0;
  std::int32_t iostat = 0, monitor_percent = 100, robot_task = -1;
  std::uint64_t statements = 0, last = kTasks - 1;  ///< last: the task that has run last
  std::array<std::int64_t, 16> timers_us{};
  std::array<Task, kTasks> tasks;
  std::vector<Variable> globals;
  std::vector<std::string> written, typed;
};

}  // namespace firn::plant::vplus
