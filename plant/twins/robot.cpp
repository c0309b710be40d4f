#include "plant/twins/robot.h"

#include <algorithm>
#include <cmath>

#include "core/grid/random.h"
#include "plant/twins/arm_controller.h"

namespace firn::plant {

using namespace fvp;

namespace {

constexpr std::int64_t kInterpret_us = 20'000;  ///< from a command to the motion that it starts
constexpr double kWatchdog_us = 1e6;            ///< of the host's time

}  // namespace

RobotTwin::RobotTwin(const IceArmParams& params, std::uint64_t seed, double host_scale, IceWires& wires)
    : Twin(Port::kRobot, TwinLink(0.0, params.latency_us)),
      params_(params),
      seed_(seed),
      watchdog_us_(std::int64_t(kWatchdog_us * host_scale)),
      wires_(wires) {}

// A socket that closes says that nobody is there: no need to wait for the watchdog.
void RobotTwin::disconnected(std::int64_t now_us) {
  line_.clear();
  if (state_.motion == Motion::kMove || state_.motion == Motion::kPath)
    fail(int(Nak::kWatchdog), now_us, DeviceEvent::kRobotWatchdog);
}

void RobotTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    if (line_.size() <= kLongestLine) line_.push_back(char(b));
    if (char(b) != '\n') continue;
    line(line_, now_us);
    line_.clear();
  }
}

// A damaged line is dropped. Number 0 is executed and neither answered nor remembered.
void RobotTwin::line(std::string_view text, std::int64_t now_us) {
  const auto request = request_of(text);
  if (!request) return;
  state_.seen_us = now_us;
  if (request->number == 0) {
    Words words(request->text);
    if (words.next() == "PATH" && words.next() == "P") add_points(words);
    return;
  }
  if (!request->text.starts_with("HELLO")) {
    if (request->number == state_.last_seq) return link_.reply(reply_, now_us);
    if (state_.last_seq != 0 && !is_newer(request->number, state_.last_seq))
      return link_.reply(reply_line(request->number, refused(Nak::kNumber, "old number")), now_us);
  }
  reply_ = reply_line(request->number, execute(request->text, now_us));
  state_.last_seq = request->number;
  link_.reply(reply_, now_us);
}

std::string RobotTwin::refused_here() const { return refused(Nak::kState, word_of(shown())); }

fvp::State RobotTwin::shown() const {
  using S = fvp::State;
  if (state_.boot_until_us > 0) return S::kBoot;
  if (state_.estop) return S::kEstop;
  if (state_.fault) return S::kFault;
  if (state_.motion != Motion::kNone && state_.motion != Motion::kBraking) return S::kRunning;
  if (state_.held) return S::kHold;
  if (state_.loading >= 0) return S::kLoading;
  const bool path_held =
      std::any_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.verified != 0; });
  return state_.power && state_.calibrated && path_held ? S::kReady : S::kIdle;
}

std::string RobotTwin::status() const {
  Report r;
  r.state = shown();
  r.state_1 = !state_.power ? 2 : state_.calibrated_at_us != kNever ? 5 : state_.calibrated ? 7 : 8;
  r.state_2 = state_.motion != Motion::kNone ? 1 : state_.state2;
  r.boots = boot_count_;
  r.power = state_.power;
  r.calibrated = state_.power && state_.calibrated;  // V+ shows it by STATE(1) == 7, which needs power
  r.speed_percent = state_.speed;
  r.error = state_.error;
  r.running_path = state_.motion == Motion::kPath ? state_.running : 0;
  r.points_passed = state_.at;
  r.ended_path = state_.last;
  r.reached_end = state_.last_done;
  r.ended_ms = state_.last_ms;
  for (std::size_t n = 0; n < slots_.size(); ++n) r.slots[n] = slots_[n].verified ? slots_[n].id : 0;
  return text_of(r);
}

std::string RobotTwin::execute(std::string_view text, std::int64_t now_us) {
  Words words(text);
  const std::string_view verb = words.next();
  if (state_.motion == Motion::kPath)
    state_.at = int(std::clamp<std::int64_t>((now_us - state_.begins_us) / 16'000, 0, kMaxPoints));
  if (verb == "HELLO") return "ACK OK C40 1 TICK=0.016";
  if (verb == "STAT") {
    if (words.next() != "J") return "ACK " + status();
    return "ACK " + text_of(nearest_point(wires_.nature().arm().encoders()));
  }
  if (verb == "HB") return "ACK " + std::string(word_of(shown()));
  if (verb == "STOP") {
    halt(now_us, params_.brake_s, DeviceEvent::kRobotBraked);
    return "ACK";
  }
  if (verb == "ESTOP") {
    trip(now_us, -1);
    return "ACK";
  }
  if (verb == "PATH") return path(words, now_us);
  if (verb == "CLEAR") {
    if (state_.pressed) return refused(Nak::kState, "emergency stop is pressed");
    if (wires_.nature().arm().commanded()) return refused(Nak::kState, "still braking");
    if (state_.motion == Motion::kBraking) state_.motion = Motion::kNone;
    state_.held = state_.fault = state_.estop = 0;
    state_.error = 0;
    state_.state2 = 0;
    return "ACK";
  }
  const bool refuses = state_.boot_until_us > 0 || state_.estop || state_.fault;
  if (verb == "SIG") {
    const int mask = int(words.integer(0, 7));
    if (!words.good()) return refused(Nak::kRange, "mask 0 to 7");
    if (refuses && mask != 0) return refused_here();  // off is never refused
    set_signals(mask, now_us);
    return "ACK " + std::to_string(mask);
  }
  if (refuses) return refused_here();
  if (verb == "POWER") {
    const bool on = words.integer(0, 1) != 0;
    if (!words.good()) return refused(Nak::kRange, "POWER 0 or 1");
    if (!on && state_.motion != Motion::kNone) return refused(Nak::kState, "moving");
    if (!on) {
      state_.power = 0;
      state_.power_at_us = state_.calibrated_at_us = kNever;
    }
    if (on && !state_.power && !state_.powerless) state_.power_at_us = now_us + kPower_us;
    return "ACK";
  }
  if (verb == "CAL") {
    if (!state_.power) return refused(Nak::kNoPower, "no power");
    if (state_.motion != Motion::kNone) return refused(Nak::kState, "moving");
    state_.calibrated = 0;
    state_.calibrated_at_us = now_us + kCalibrate_us;
    return "ACK";
  }
  if (verb == "SPEED") {
    const auto percent = std::int32_t(words.integer(1, 100));
    if (!words.good()) return refused(Nak::kRange, "1 to 100 percent");
    state_.speed = percent;
    return "ACK " + std::to_string(percent);
  }
  if (verb != "MOVEJ" && verb != "MOVEZ") return refused(Nak::kRange, "unknown verb");
  Joints to = wires_.nature().arm().reference();
  if (verb == "MOVEJ") {
    const auto point = next_point(words);
    if (point) to = joints_at(*point);
  } else {
    to[2] = double(words.integer(-kMaxCount, kMaxCount)) * 1e-3;
  }
  const auto percent = double(words.integer(1, 100));
  if (!words.good()) return refused(Nak::kRange, "numbers of a move");
  return move(to, percent, now_us);
}

std::string RobotTwin::move(const Joints& to, double percent, std::int64_t now_us) {
  if (!state_.power) return refused(Nak::kNoPower, "no power");
  if (!state_.calibrated) return refused(Nak::kNotCalibrated, "not calibrated");
  if (state_.motion != Motion::kNone || state_.held || state_.fault || state_.estop) return refused_here();
  if (!in_range(params_, to)) return refused(Nak::kJointLimit, "beyond a joint's range");
  TrueArm& arm = wires_.nature().arm();
  const Joints from = arm.reference();
  std::vector<Joints> points = joint_move(from, to, percent / 100.0 * state_.speed / 100.0);
  state_.motion = Motion::kMove;
  state_.running = 0;
  state_.begins_us = now_us + kInterpret_us;
  state_.ends_us = state_.begins_us + std::int64_t(std::ceil(double(points.size() - 1) * kRobotTick_s * 1e6 *
                                                             (1.0 + params_.clock_ppm * 1e-6)));
  arm.follow(std::move(points), kRobotTick_s, double(state_.begins_us) * 1e-6);
  wires_.note(now_us, port_, DeviceEvent::kRobotMotion, 0);
  return "ACK";
}

std::string RobotTwin::run(std::int32_t id, int mask, std::int64_t now_us) {
  if (!state_.power) return refused(Nak::kNoPower, "no power");
  if (!state_.calibrated) return refused(Nak::kNotCalibrated, "not calibrated");
  if (state_.motion != Motion::kNone || state_.held || state_.fault || state_.estop) return refused_here();
  if (state_.speed != 100) return refused(Nak::kMonitorSpeed, "monitor speed is not 100");
  const Slot* slot = find(id);
  if (!slot || !slot->verified) return refused(Nak::kState, "no such path");
  TrueArm& arm = wires_.nature().arm();
  std::vector<Joints> points;
  points.reserve(slot->points.size());
  for (const Point& c : slot->points) points.push_back(joints_at(c));
  for (std::size_t n = 0; n < 4; ++n)
    if (std::abs(points.front()[n] - arm.reference()[n]) > (n == 2 ? 0.05 : 0.01 * kRobotRad))
      return refused(Nak::kState, "not at the first point");

  // DURATION is a minimum: a motion that a joint cannot follow in a tick takes longer, and so does a path now
  // and then.
  double tick_s = kRobotTick_s;
  for (std::size_t k = 1; k < points.size(); ++k)
    for (std::size_t n = 0; n < 4; ++n)
      tick_s = std::max(tick_s, std::abs(points[k][n] - points[k - 1][n]) / kFullRate[n]);
  const auto number = std::uint32_t(++state_.paths);
  const double span_s = double(points.size() - 1);
  if (random_uniform({seed_, Purpose::kInstrument, 5, 0, number}) < params_.slip_probability)
    tick_s += params_.slip_s / span_s;
  const double delay_s = params_.start_delay_s +
                         params_.start_jitter_s * random_uniform({seed_, Purpose::kInstrument, 5, 1, number});
  state_.motion = Motion::kPath;
  state_.running = id;
  state_.at = 0;
  state_.wanted_mask = mask;
  state_.signal_us = now_us + kInterpret_us;
  state_.begins_us = state_.signal_us + std::int64_t(std::llround(delay_s * 1e6));
  state_.ends_us =
      state_.begins_us + std::int64_t(std::ceil(span_s * tick_s * 1e6 * (1.0 + params_.clock_ppm * 1e-6)));
  arm.follow(std::move(points), tick_s, double(state_.begins_us) * 1e-6);
  wires_.note(now_us, port_, DeviceEvent::kRobotMotion, id);
  return "ACK";
}

std::int64_t RobotTwin::next_device_us() const {
  std::int64_t next =
      std::min({state_.power_at_us, state_.calibrated_at_us, state_.signal_us, state_.ends_us});
  if (state_.boot_until_us > 0) next = std::min(next, state_.boot_until_us);
  if (state_.motion == Motion::kPath) next = std::min(next, state_.seen_us + watchdog_us_);
  return next;
}

void RobotTwin::device_event(std::int64_t now_us) {
  if (now_us == state_.boot_until_us) state_.boot_until_us = 0;
  if (now_us == state_.power_at_us) {
    state_.power = 1;
    state_.power_at_us = kNever;
  }
  if (now_us == state_.calibrated_at_us) {
    state_.calibrated = 1;
    state_.calibrated_at_us = kNever;
  }
  if (now_us == state_.signal_us) {
    state_.signal_us = kNever;
    set_signals(state_.mask | state_.wanted_mask, now_us);
  }
  if (now_us == state_.ends_us) return finish(now_us, true);
  if (state_.motion == Motion::kPath && now_us >= state_.seen_us + watchdog_us_)
    fail(int(Nak::kWatchdog), now_us, DeviceEvent::kRobotWatchdog);
}

void RobotTwin::set_signals(int mask, std::int64_t now_us) {
  if (mask == state_.mask) return;
  state_.mask = mask;
  wires_.note(now_us, port_, DeviceEvent::kSignals, mask);
  wires_.signals(now_us, mask);
}

void RobotTwin::event(std::string_view kind, std::int64_t now_us) {
  state_.event = state_.event >= kMaxNumber ? 1 : state_.event + 1;
  link_.reply(event_line(state_.event, kind), now_us);
}

// Sets the result of a motion, complete or not, that STAT reports from now on.
void RobotTwin::finish(std::int64_t now_us, bool done) {
  const bool was_path = state_.motion == Motion::kPath;
  const double clock = 1.0 + params_.clock_ppm * 1e-6;
  const auto ms =
      std::int32_t(std::lround(double(std::max<std::int64_t>(0, now_us - state_.begins_us)) * 1e-3 / clock));
  state_.motion = done ? Motion::kNone : Motion::kBraking;
  state_.ends_us = state_.signal_us = kNever;
  state_.state2 = done ? 2 : 3;
  if (was_path) {
    set_signals(state_.mask & ~state_.wanted_mask, now_us);
    state_.last = state_.running;
    state_.last_done = done;
    state_.last_ms = ms;
    state_.at = int(std::clamp<std::int64_t>((now_us - state_.begins_us) / 16'000, 0, kMaxPoints));
    if (const Slot* slot = find(state_.running); done && slot) state_.at = int(slot->points.size());
  }
  if (!done) return;
  wires_.note(now_us, port_, DeviceEvent::kRobotRest, state_.running);
  event((was_path ? "PATH_DONE " + std::to_string(state_.running) + " " + std::to_string(ms)
                  : std::string("MOVE_DONE")) +
            ' ' + text_of(nearest_point(wires_.nature().arm().encoders())),
        now_us);
  state_.running = 0;
}

void RobotTwin::halt(std::int64_t now_us, double within_s, DeviceEvent why) {
  const bool moving = state_.motion == Motion::kMove || state_.motion == Motion::kPath;
  set_signals(0, now_us);
  wires_.valves_off(now_us);
  if (!moving) return;
  wires_.note(now_us, port_, why, state_.running);
  wires_.nature().arm().brake(within_s);
  finish(now_us, false);
  state_.held = 1;
}

void RobotTwin::fail(int error, std::int64_t now_us, DeviceEvent why) {
  halt(now_us, params_.brake_s, why);
  state_.fault = 1;
  state_.error = error;
  state_.state2 = 7;
  event("MOTION_ERR " + std::to_string(state_.power ? 7 : 2) + " 7 " + std::to_string(error), now_us);
}

void RobotTwin::trip(std::int64_t now_us, std::int64_t code) {
  if (code == 0) state_.pressed = state_.powerless = 0;
  if (code == 3) state_.powerless = 1;
  if (code == 2) fail(kMotionError, now_us, DeviceEvent::kRobotError);
  if (code != 1 && code != -1) return;  // -1: by command
  halt(now_us, kStopPower_s, DeviceEvent::kRobotBraked);
  state_.pressed = code == 1;
  state_.power = 0;
  state_.power_at_us = kNever;
  state_.calibrated_at_us = kNever;
  state_.estop = 1;
  state_.state2 = 8;
}

void RobotTwin::reboot(std::int64_t now_us) {
  halt(now_us, kStopPower_s, DeviceEvent::kRobotBraked);
  ++boot_count_;
  const std::int64_t paths = state_.paths;
  const std::uint8_t pressed = state_.pressed;
  state_ = State{};
  state_.paths = paths;
  state_.pressed = pressed;
  state_.boot_until_us = now_us + kBoot_us;
  slots_ = {};
  line_.clear();
  reply_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void RobotTwin::io(Archive& a) { a.all(boot_count_, state_, slots_[0], slots_[1], line_, reply_, link_); }

}  // namespace firn::plant
