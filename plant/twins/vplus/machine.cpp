#include "plant/twins/vplus/machine.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace firn::plant::vplus {
namespace {

constexpr double kSlice_us = 1000.0;

}  // namespace

Machine::Machine(const Code& code, RobotPort& robot, const MachineOptions& options)
    : c_(code, robot, options), executor_(c_) {
  if (options.statements_per_tick < kSlices || options.statements_per_tick > 1'000'000)
    throw std::invalid_argument("V+: statements_per_tick of 16 to 1000000");
}

std::int64_t Machine::time_of(std::int64_t index) const {
  return std::int64_t(std::ceil(double(index) * kSlice_us * c_.clock()));
}

std::int64_t Machine::index_after(std::int64_t t_us) const {
  auto index = std::int64_t(double(t_us) / (kSlice_us * c_.clock()));
  while (time_of(index) < t_us) ++index;
  return index;
}

void Machine::execute(std::size_t task, const std::string& program, std::int64_t now_us) {
  const auto found = c_.code.program_of.find(program);
  if (found == c_.code.program_of.end()) throw std::invalid_argument("V+: no program is called " + program);
  happened(now_us);
  c_.start(c_.tasks.at(task), found->second);
}

void Machine::set(const std::string& global, float value) {
  const auto found = c_.code.global_of.find(global);
  if (found != c_.code.global_of.end()) c_.globals[found->second].scalar = Value::of(value);
}

Value Machine::get(const std::string& global) const {
  const auto found = c_.code.global_of.find(global);
  return found == c_.code.global_of.end() ? Value{} : c_.globals[found->second].scalar;
}

void Machine::happened(std::int64_t now_us) { c_.now_us = std::max(c_.now_us, now_us); }

bool Machine::ready(const Task& task) const {
  if (!task.runs) return false;
  if (task.raised != 0) return true;
  switch (task.wait) {
    case Wait::kNone:
      return true;
    case Wait::kTick:
      return false;
    case Wait::kMotion:
      return !c_.robot.waiting();
    case Wait::kRest:
      return !c_.robot.waiting() && !c_.robot.moving();
    case Wait::kCalibration:
      return !c_.robot.calibrating();
  }
  return false;
}

std::int64_t Machine::next_us() const {
  bool waits = false;
  const std::int64_t next = std::max(c_.slice, index_after(c_.now_us));
  for (const Task& task : c_.tasks) {
    if (ready(task)) return time_of(next);
    waits |= task.runs && task.wait == Wait::kTick;
  }
  return waits ? time_of((next + kSlices - 1) / kSlices * kSlices) : kNeverRuns;
}

void Machine::slice(std::int64_t now_us) {
  c_.now_us = now_us;
  const std::int64_t index = index_after(now_us), share = c_.options.statements_per_tick;
  c_.slice = index + 1;
  if (index % kSlices == 0)
    for (Task& task : c_.tasks)
      if (task.wait == Wait::kTick) task.wait = Wait::kNone;
  std::int64_t budget = (index % kSlices + 1) * share / kSlices - index % kSlices * share / kSlices;
  while (budget > 0) {
    std::size_t chosen = kTasks;
    for (std::size_t n = 0; n < kTasks; ++n) {
      const std::size_t task = (n + 1 + c_.last) % kTasks;
      if (ready(c_.tasks[task]) &&
          (chosen == kTasks || c_.options.priorities[task] > c_.options.priorities[chosen]))
        chosen = task;
    }
    if (chosen == kTasks) return;
    c_.last = chosen;
    run_task(chosen, budget);
  }
}

void Machine::run_task(std::size_t n, std::int64_t& budget) {
  Task& task = c_.tasks[n];
  task.wait = Wait::kNone;
  while (budget > 0 && task.runs && ready(task)) {
    --budget;
    ++c_.statements;
    try {
      if (const int code = std::exchange(task.raised, 0)) throw Trouble{code, "error of the robot"};
      executor_.step(task);
    } catch (const Trouble& trouble) {
      fail(task, trouble);
    }
  }
}

void Machine::fail(Task& task, const Trouble& trouble) {
  task.error = trouble.code;
  task.wait = Wait::kNone;
  const Frame& f = task.frames.back();
  const Program& p = c_.code.programs[f.program];
  const bool reacts =
      std::any_of(task.frames.begin(), task.frames.end(), [](const Frame& x) { return x.reaction; });
  if (task.reaction >= 0 && !reacts) {
    task.frames.push_back(c_.frame_of(std::uint32_t(task.reaction)));
    task.frames.back().reaction = true;
    return;
  }
  const std::size_t at = std::min<std::size_t>(f.at, p.statements.size() - 1);
  task.stopped_by = p.file + ":" + std::to_string(p.statements[at].line) + ": " + trouble.what + " (" +
                    std::to_string(trouble.code) + ")";
  task.runs = false;
}

void Machine::arm_error(int code) {
  if (c_.robot_task < 0) return;
  Task& task = c_.tasks[std::size_t(c_.robot_task)];
  task.error = code;
  if (task.runs) task.raised = code;
}

std::vector<std::string> Machine::take_written() { return std::exchange(c_.written, {}); }

}  // namespace firn::plant::vplus
