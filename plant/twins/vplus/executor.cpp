#include "plant/twins/vplus/executor.h"

#include <algorithm>
#include <cmath>

namespace firn::plant::vplus {
namespace {

constexpr int kTooManyCalls = -320;  // the numbers of these are not checked
constexpr int kNoReturn = -321;
constexpr int kIllegalTask = -402;
constexpr int kNoRobotAttached = -602;
constexpr std::size_t kDeepestCall = 32;
constexpr std::size_t kMostTyped = 100;
constexpr std::size_t kMostWritten = 4096;  // lines that nobody has taken

}  // namespace

void Executor::step(Task& task) {
  const Frame& f = task.frames.back();
  const Statement& s = c_.code.programs[f.program].statements[f.at];
  const auto jump = [&](std::uint32_t to) { task.frames.back().at = to; };
  switch (s.verb) {
    case Verb::kAssign: {
      Value v = value(task, s.values[1]);
      store(task, s.values[0], std::move(v));
      break;
    }
    case Verb::kUnless:
      if (real(task, s.values[0]) == 0.0F) return jump(s.target);
      break;
    case Verb::kJump:
      return jump(s.target);
    case Verb::kForBegin:
      return for_begin(task, s);
    case Verb::kForNext:
      return for_next(task, s);
    case Verb::kCase: {
      const float selector = real(task, s.values[0]);
      task.frames.back().slots[s.slot][0] = selector;
      break;
    }
    case Verb::kBranch:
      return branch(task, s);
    case Verb::kNothing:
    case Verb::kNull:
      break;
    case Verb::kCall:
      return call(task, s);
    case Verb::kReturn:
    case Verb::kResume:
      return come_back(task);
    case Verb::kOnError:
      task.reaction = std::int32_t(s.target);
      break;
    case Verb::kWait:
      task.wait = Wait::kTick;
      break;
    case Verb::kExecute: {
      const std::int32_t other = integer(task, s.values[0]);
      if (other < 0 || std::size_t(other) >= kTasks || c_.tasks[std::size_t(other)].runs)
        throw Trouble{kIllegalTask, "this task runs, or there is none"};
      c_.start(c_.tasks[std::size_t(other)], s.target);
      break;
    }
    case Verb::kTimer: {
      const std::int32_t of = integer(task, s.values[0]);
      if (of < 0 || std::size_t(of) >= c_.timers_us.size()) throw Trouble{kIllegalTask, "no such timer"};
      const double back_us = double(real(task, s.values[1])) * 1e6 * c_.clock();
      if (!(std::abs(back_us) < 1e15)) throw Trouble{kIllegalTask, "no such time"};
      c_.timers_us[std::size_t(of)] = c_.now_us - std::int64_t(back_us);
      break;
    }
    case Verb::kSignal: {
      std::vector<int> numbers;
      for (const Expression e : s.values) numbers.push_back(integer(task, e));
      c_.robot.signals(numbers);
      break;
    }
    case Verb::kType: {
      std::string line;
      for (const Expression e : s.values)
        line += c_.code.nodes[e].type == Type::kString ? text(task, e) : std::to_string(real(task, e));
      if (c_.typed.size() >= kMostTyped) c_.typed.erase(c_.typed.begin());
      c_.typed.push_back(std::move(line));
      break;
    }
    case Verb::kAttach:
    case Verb::kOpen:
    case Verb::kCommand:
    case Verb::kRead:
    case Verb::kWrite:
      device(task, s);
      break;
    default:
      motion(task, s);
  }
  ++task.frames.back().at;
}

void Executor::call(Task& task, const Statement& s) {
  if (task.frames.size() >= kDeepestCall) throw Trouble{kTooManyCalls, "too many subroutine calls"};
  Frame next = c_.frame_of(s.target);
  for (std::size_t n = 0; n < s.values.size(); ++n) {
    Local& parameter = next.locals[n];
    const Node& given = c_.code.nodes[s.values[n]];
    if (given.op == Operator::kVariable && !given.in_brackets) {
      parameter.is_reference = true;
      parameter.to = reference(task, s.values[n]);
    } else {
      parameter.own.scalar = value(task, s.values[n]);
    }
  }
  ++task.frames.back().at;
  task.frames.push_back(std::move(next));
}

void Executor::come_back(Task& task) {
  const Frame f = std::move(task.frames.back());
  const bool resumes = c_.code.programs[f.program].statements[f.at].verb == Verb::kResume;
  if (f.reaction != resumes) {
    task.frames.back() = f;
    throw Trouble{kNoReturn, "RETURNE belongs at the end of an error's program, and nowhere else"};
  }
  task.frames.pop_back();
  if (f.reaction) ++task.frames.back().at;  // past the statement that failed
  task.runs = !task.frames.empty();
}

void Executor::for_begin(Task& task, const Statement& s) {
  const float first = real(task, s.values[1]), last = real(task, s.values[2]);
  const float by = s.values.size() > 3 ? real(task, s.values[3]) : 1.0F;
  store(task, s.values[0], Value::of(first));
  Frame& f = task.frames.back();
  f.slots[s.slot] = {last, by};
  f.at = (by >= 0.0F ? first > last : first < last) ? s.target : f.at + 1;
}

void Executor::for_next(Task& task, const Statement& s) {
  const auto [last, by] = task.frames.back().slots[s.slot];
  const float now = real(task, s.values[0]) + by;
  store(task, s.values[0], Value::of(now));
  Frame& f = task.frames.back();
  f.at = (by >= 0.0F ? now > last : now < last) ? f.at + 1 : s.target;
}

void Executor::branch(Task& task, const Statement& s) {
  const float selector = task.frames.back().slots[s.slot][0];
  const bool meets =
      std::any_of(s.values.begin(), s.values.end(), [&](Expression e) { return real(task, e) == selector; });
  Frame& f = task.frames.back();
  f.at = meets ? f.at + 1 : s.target;
}

void Executor::device(Task& task, const Statement& s) {
  const auto number = [&](std::size_t n) { return integer(task, s.values[n]); };
  std::vector<std::string> texts;
  if (s.verb != Verb::kRead)
    for (std::size_t n = 2; n < s.values.size(); ++n) texts.push_back(text(task, s.values[n]));
  switch (s.verb) {
    case Verb::kAttach:
      c_.iostat = c_.network.attach(texts[0]);
      break;
    case Verb::kOpen:
      c_.iostat = c_.network.open(texts);
      break;
    case Verb::kCommand:
      c_.iostat = c_.network.command(number(1));
      break;
    case Verb::kWrite: {
      c_.iostat = c_.network.can_write() ? int(kDone) : int(kNoDevice);
      if (!c_.network.can_write() || c_.written.size() >= kMostWritten) break;
      std::string line;
      for (const std::string& part : texts) line += part;
      c_.written.push_back(line + (s.target ? "\r\n" : ""));
      break;
    }
    default: {
      std::string piece;
      c_.iostat = c_.network.read(piece);
      if (c_.iostat == kNothingYet && number(2) == 0) {  // READ that waits: it is tried again at each tick
        task.wait = Wait::kTick;
        --task.frames.back().at;
        return;
      }
      if (c_.iostat == kNothingYet) return;
      constexpr float kHandle = 1.0F;  // the one client's
      store(task, s.values[1], Value::of(kHandle));
      store(task, s.values[3], Value::of(std::move(piece)));
    }
  }
}

void Executor::motion(Task& task, const Statement& s) {
  const auto needs_robot = [&] {
    if (c_.robot_task < 0 || &c_.tasks[std::size_t(c_.robot_task)] != &task)
      throw Trouble{kNoRobotAttached, "no robot is attached to this task"};
  };
  const auto percent_of = [&](std::size_t n) {
    const float p = real(task, s.values[n]);
    if (!(p > 0.0F && p <= 100.0F))
      throw Trouble{kIllegalTask, "a speed of more than 0 and at most 100 percent"};
    return p;
  };
  switch (s.verb) {
    case Verb::kSelect:
      task.selected = integer(task, s.values[0]) == 1;
      break;
    case Verb::kAttachRobot:
      if (!task.selected) throw Trouble{kNoRobotAttached, "no robot is selected"};
      c_.robot_task = std::int32_t(&task - c_.tasks.data());
      break;
    case Verb::kCalibrate:
      needs_robot();
      if (const int code = c_.robot.calibrate(); code != 0)
        throw Trouble{code, "the robot does not calibrate"};
      task.wait = Wait::kCalibration;
      break;
    case Verb::kPower:
      c_.robot.power(s.target != 0);
      break;
    case Verb::kSpeed: {
      const float p = percent_of(0);
      if (s.target == kMonitor) c_.monitor_percent = std::int32_t(p);
      if (s.target == kAlways) task.percent = p;
      task.next_percent = s.target == kNextMotion ? p : task.next_percent;
      break;
    }
    case Verb::kDuration: {
      const float d = real(task, s.values[0]);
      if (!(d >= 0.0F && d < 1000.0F)) throw Trouble{kIllegalTask, "no such duration"};
      (s.target == kAlways ? task.duration_s : task.next_duration_s) = d;
      break;
    }
    case Verb::kMove:
      needs_robot();
      move(task, s);
      break;
    case Verb::kBreak:
      needs_robot();
      task.wait = Wait::kRest;
      break;
    case Verb::kBrake:
      c_.robot.brake();
      break;
    case Verb::kHere:
      store(task, s.values[0], Value::of(c_.robot.here()));
      break;
    default: {  // kDecompose
      const Value from = value(task, s.values[1]);
      Reference to = reference(task, s.values[0]);
      for (const float joint : from.point) {
        store(task, to, Value::of(joint));
        ++to.element;
      }
    }
  }
}

void Executor::move(Task& task, const Statement& s) {
  Motion m;
  m.to = value(task, s.values[0]).point;
  const double monitor = c_.monitor_percent / 100.0;
  m.percent = double(task.next_percent > 0.0F ? task.next_percent : task.percent) * monitor;
  // A duration is meant at a monitor speed of 100 percent.
  m.duration_s = double(task.next_duration_s >= 0.0F ? task.next_duration_s : task.duration_s) / monitor;
  task.next_percent = 0.0F;
  task.next_duration_s = -1.0F;
  if (const int code = c_.robot.give(m); code != 0) throw Trouble{code, "the robot refuses the motion"};
  task.wait = Wait::kMotion;
}

}  // namespace firn::plant::vplus
