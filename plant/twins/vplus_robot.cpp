#include "plant/twins/vplus_robot.h"

#include <algorithm>
#include <cmath>

#include "core/grid/random.h"
#include "plant/twins/arm_controller.h"

namespace firn::plant {
namespace {

constexpr double kStroke_mm =
    210.0;  ///< of joint 3: V+ counts from its highest end downwards, the arm from its lowest
// Errors of V+; of the last three the numbers are not checked on a controller.
constexpr int kOutOfRange = -610, kNoPower = -604, kNotCalibrated = -605, kEmergencyStop = -609;

Joints arm_joints(const vplus::PrecisionPoint& p) {
  return {double(p[0]) * kRobotRad, double(p[1]) * kRobotRad, kStroke_mm - double(p[2]),
          double(p[3]) * kRobotRad};
}

vplus::PrecisionPoint vplus_joints(const Joints& q) {
  return {float(q[0] / kRobotRad), float(q[1] / kRobotRad), float(kStroke_mm - q[2]),
          float(q[3] / kRobotRad)};
}

vplus::Code parsed(const IceRobotProgram& program) {
  std::vector<vplus::Source> sources;
  for (const IceProgramText& t : program.texts) sources.push_back({t.file, t.text});
  return vplus::parse(sources);
}

vplus::MachineOptions options_of(const IceRobotProgram& program, const IceArmParams& params) {
  vplus::MachineOptions o;
  o.statements_per_tick = program.statements_per_tick;
  o.clock_ppm = params.clock_ppm;
  return o;
}

}  // namespace

VplusRobotTwin::VplusRobotTwin(const IceArmParams& params, const IceRobotProgram& program, std::uint64_t seed,
                               IceWires& wires)
    : Twin(Port::kRobot, TwinLink(0.0, params.latency_us)),
      params_(params),
      seed_(seed),
      wires_(wires),
      code_(parsed(program)),
      options_(options_of(program, params)),
      machine_(code_, *this, options_) {
  start();
}

// fv.boot is kept on the controller's disk: it is not there before the first start.
void VplusRobotTwin::start() {
  if (boot_count_ > 1) machine_.set("fv.boot", float(boot_count_ - 1));
  machine_.execute(0, "a.firn", now_us_);
}

void VplusRobotTwin::connected(std::int64_t now_us) {
  machine_.happened(now_us);
  machine_.network().connected();
}

void VplusRobotTwin::disconnected(std::int64_t now_us) {
  machine_.happened(now_us);
  machine_.network().disconnected();
}

void VplusRobotTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  machine_.happened(now_us);
  if (machine_.network().arrived({reinterpret_cast<const char*>(bytes.data()), bytes.size()})) return;
  link_.close(now_us);
  wires_.link_closed(now_us, port_);
  machine_.network().disconnected();
}

std::int64_t VplusRobotTwin::next_device_us() const {
  if (state_.boot_until_us > 0) return state_.boot_until_us;
  return std::min({machine_.next_us(), state_.power_at_us, state_.calibrated_at_us, state_.ends_us});
}

void VplusRobotTwin::device_event(std::int64_t now_us) {
  now_us_ = now_us;
  if (state_.boot_until_us > 0) {
    state_.boot_until_us = 0;
    return start();
  }
  machine_.happened(now_us);
  if (now_us == state_.power_at_us) {
    state_.power = 1;
    state_.power_at_us = kNever;
  }
  if (now_us == state_.calibrated_at_us) {
    state_.calibrated = 1;
    state_.calibrated_at_us = kNever;
  }
  if (now_us == state_.ends_us) ended();
  if (now_us == machine_.next_us()) machine_.slice(now_us);
  flush();
}

void VplusRobotTwin::flush() {
  for (const std::string& line : machine_.take_written()) link_.reply(line, now_us_);
}

// Signals 1 to 3 are valve_a, valve_b and the laser; 4 is the enable line of both valves.
void VplusRobotTwin::signals(std::span<const int> numbers) {
  constexpr int kEnable = 4;
  int mask = state_.mask;
  bool disables = false;
  for (const int n : numbers) {
    const int bit = std::abs(n) >= 1 && std::abs(n) < kEnable ? 1 << (std::abs(n) - 1) : 0;
    mask = n > 0 ? mask | bit : mask & ~bit;
    disables |= n == -kEnable;
  }
  if (mask != state_.mask) {
    state_.mask = mask;
    wires_.note(now_us_, port_, DeviceEvent::kSignals, mask);
    wires_.signals(now_us_, mask);
  }
  if (disables) wires_.valves_off(now_us_);
}

void VplusRobotTwin::power(bool on) {
  if (on) {
    const bool comes = !state_.power && !state_.powerless && !state_.pressed;
    if (comes && state_.power_at_us == kNever) state_.power_at_us = now_us_ + kPower_us;
    return;
  }
  if (moving()) machine_.arm_error(kNoPower);
  halt(kStopPower_s, DeviceEvent::kRobotBraked);
  state_.waiting = Kind::kNone;
  state_.power = 0;
  state_.power_at_us = state_.calibrated_at_us = kNever;
}

int VplusRobotTwin::calibrate() {
  if (!state_.power) return kNoPower;
  state_.calibrated = 0;
  state_.calibrated_at_us = now_us_ + kCalibrate_us;
  return 0;
}

int VplusRobotTwin::state(int number) const {
  constexpr int kStopPressed = 4;  // bit of STATE(4) [adept_experimental]
  switch (number) {
    case 1:
      return !state_.power ? 2 : calibrating() ? 5 : state_.calibrated ? 7 : 8;
    case 2:
      return state_.kind == Kind::kMove || state_.kind == Kind::kPath ? 1 : state_.state2;
    case 4:
      return state_.pressed ? kStopPressed : 0;
    default:
      return 0;
  }
}

vplus::PrecisionPoint VplusRobotTwin::here() const { return vplus_joints(wires_.nature().arm().encoders()); }

vplus::PrecisionPoint VplusRobotTwin::destination() const {
  return vplus_joints(moving() ? state_.to : wires_.nature().arm().reference());
}

int VplusRobotTwin::give(const vplus::Motion& motion) {
  if (state_.pressed) return kEmergencyStop;
  if (!state_.power) return kNoPower;
  if (!state_.calibrated) return kNotCalibrated;
  const Joints to = arm_joints(motion.to);
  if (!in_range(params_, to)) return kOutOfRange;
  state_.next = to;
  state_.percent = motion.percent;
  state_.waiting_s = motion.duration_s;
  if (state_.slips && state_.kind == Kind::kPath &&
      motion.duration_s > 0.0) {  // now and then a motion takes longer
    state_.waiting_s += params_.slip_s;
    state_.slips = 0;
  }
  state_.waiting = motion.duration_s > 0.0 ? Kind::kPath : Kind::kMove;
  if (state_.kind == Kind::kNone) {
    begin(state_.waiting, double(now_us_) * 1e-6);
  } else if (state_.kind == Kind::kPath && state_.waiting == Kind::kPath) {
    // It follows without a stop: the arm must know it before the motion before has ended.
    TrueArm& arm = wires_.nature().arm();
    std::vector<Joints> points = segment(state_.to, to, state_.waiting_s);
    if (arm.commanded()) {
      points.erase(points.begin());
      arm.extend(points);
    } else {
      arm.follow(std::move(points), kRobotTick_s, state_.ends_s);
    }
  }
  return 0;
}

// Points kRobotTick_s apart. The duration is a minimum: a joint that cannot follow takes longer.
std::vector<Joints> VplusRobotTwin::segment(const Joints& from, const Joints& to, double span_s) const {
  for (std::size_t n = 0; n < 4; ++n) span_s = std::max(span_s, std::abs(to[n] - from[n]) / kFullRate[n]);
  const int ticks = std::max(1, int(std::ceil(span_s / kRobotTick_s - 1e-6)));
  std::vector<Joints> points;
  for (int k = 0; k <= ticks; ++k) {
    Joints q{};
    for (std::size_t n = 0; n < 4; ++n) q[n] = from[n] + (to[n] - from[n]) * k / ticks;
    points.push_back(q);
  }
  points.back() = to;
  return points;
}

// The motion that waits begins at start_s.
void VplusRobotTwin::begin(Kind kind, double start_s) {
  TrueArm& arm = wires_.nature().arm();
  const bool goes_on = state_.kind == Kind::kPath && kind == Kind::kPath;
  state_.from = goes_on ? state_.to : arm.reference();
  state_.to = state_.next;
  state_.waiting = Kind::kNone;
  std::vector<Joints> points = kind == Kind::kPath
                                   ? segment(state_.from, state_.to, state_.waiting_s)
                                   : joint_move(state_.from, state_.to, state_.percent / 100.0);
  state_.ticks = std::int32_t(points.size() - 1);
  const double span_s = state_.ticks * kRobotTick_s * clock();
  if (!goes_on) {
    wires_.note(now_us_, port_, DeviceEvent::kRobotMotion, std::int64_t(machine_.get("fv.path").real));
    const bool is_late = kind == Kind::kPath && machine_.get("fv.at").real > 0.0F;
    if (is_late) {
      ++state_.late;
    } else if (kind == Kind::kPath) {
      const auto number = std::uint32_t(++state_.paths);
      if (random_uniform({seed_, Purpose::kInstrument, 5, 0, number}) < params_.slip_probability)
        state_.slips = 1;
      start_s += params_.start_delay_s +
                 params_.start_jitter_s * random_uniform({seed_, Purpose::kInstrument, 5, 1, number});
    }
    arm.follow(std::move(points), kRobotTick_s, start_s);
  }
  state_.kind = kind;
  state_.ends_s = start_s + span_s;
  state_.ends_us = std::int64_t(std::ceil(state_.ends_s * 1e6));
}

// The motion that had begun is over.
void VplusRobotTwin::ended() {
  const bool braked = state_.kind == Kind::kBraking;
  state_.ends_us = kNever;
  if (state_.waiting == Kind::kPath && state_.kind == Kind::kPath) return begin(Kind::kPath, state_.ends_s);
  constexpr std::uint8_t kAsPlanned = 2, kStoppedByBrake = 6, kStoppedByError = 8;
  state_.state2 = !braked ? kAsPlanned : state_.state2 >= 7 ? kStoppedByError : kStoppedByBrake;
  state_.kind = Kind::kNone;
  if (!braked)
    wires_.note(now_us_, port_, DeviceEvent::kRobotRest, std::int64_t(machine_.get("fv.path").real));
  if (state_.waiting != Kind::kNone) begin(state_.waiting, double(now_us_) * 1e-6);
}

// A path is given point by point: the arm comes to rest along its last direction. A move is known whole.
void VplusRobotTwin::halt(double within_s, DeviceEvent why) {
  if (state_.kind != Kind::kMove && state_.kind != Kind::kPath) return;
  constexpr std::uint8_t kBraked = 5;
  TrueArm& arm = wires_.nature().arm();
  if (state_.kind == Kind::kPath) {
    const Joints at = arm.reference();
    std::vector<Joints> points;
    const int ticks = int(within_s / kRobotTick_s) + 2;
    for (int k = 0; k <= ticks; ++k) {
      Joints q{};
      for (std::size_t n = 0; n < 4; ++n) q[n] = at[n] + (state_.to[n] - state_.from[n]) * k / state_.ticks;
      points.push_back(q);
    }
    arm.follow(std::move(points), kRobotTick_s, double(now_us_) * 1e-6);
  }
  arm.brake(within_s);
  wires_.note(now_us_, port_, why, std::int64_t(machine_.get("fv.path").real));
  state_.kind = Kind::kBraking;
  state_.state2 = kBraked;
  state_.ends_s = arm.end_s();
  state_.ends_us = std::max(now_us_ + 1, std::int64_t(std::ceil(state_.ends_s * 1e6)));
}

void VplusRobotTwin::trip(std::int64_t now_us, std::int64_t code) {
  constexpr std::uint8_t kStoppingByError = 7;
  now_us_ = now_us;
  machine_.happened(now_us);
  if (code == 0) state_.pressed = state_.powerless = 0;
  if (code == 3) state_.powerless = 1;
  if (code != 1 && code != 2) return;
  const bool moved = moving();
  halt(code == 1 ? kStopPower_s : params_.brake_s,
       code == 1 ? DeviceEvent::kRobotBraked : DeviceEvent::kRobotError);
  state_.state2 = kStoppingByError;
  if (state_.kind == Kind::kNone) ++state_.state2;
  state_.waiting = Kind::kNone;
  if (code == 1) {
    state_.pressed = 1;
    state_.power = 0;
    state_.power_at_us = state_.calibrated_at_us = kNever;
  }
  if (moved || code == 2) machine_.arm_error(code == 1 ? kEmergencyStop : kMotionError);
}

void VplusRobotTwin::reboot(std::int64_t now_us) {
  now_us_ = now_us;
  halt(kStopPower_s, DeviceEvent::kRobotBraked);
  const int all_off[] = {-4, -1, -2, -3};
  signals(all_off);
  ++boot_count_;
  const State before = state_;
  state_ = State{};
  state_.paths = before.paths;
  state_.pressed = before.pressed;
  state_.boot_until_us = now_us + kBoot_us;
  // Nothing of the program is left but its values on disk.
  Archive blank;
  vplus::Machine fresh(code_, *this, options_);
  fresh.io(blank);
  Archive load(blank.bytes());
  machine_.io(load);
  machine_.happened(now_us);
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void VplusRobotTwin::io(Archive& a) {
  a.all(boot_count_, state_, now_us_, link_);
  machine_.io(a);
}

}  // namespace firn::plant
