#include "plant/twins/stage.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {
namespace {

constexpr std::size_t kQueueLimit = 16;
constexpr std::uint32_t kFaultPosition = 1u << 0, kFaultHighLimit = 1u << 4, kFaultLowLimit = 1u << 5,
                        kFaultEstop = 1u << 11;
constexpr std::uint32_t kEnabled = 1u << 0, kHomed = 1u << 1, kInPosition = 1u << 2, kMoveActive = 1u << 3,
                        kHoming = 1u << 14, kEstopInput = 1u << 31;

}  // namespace

void Pso::arm() {
  armed = true;
  next_index = pulses = 0;
  travel_mm = 0.0;
  next_counts = mode == Mode::kFixed ? fixed_counts : increments.empty() ? 0 : increments[0];
}

void Pso::advance() {
  ++next_index;
  if (mode == Mode::kFixed)
    next_counts += fixed_counts;
  else if (next_index < std::int64_t(increments.size()))
    next_counts += increments[std::size_t(next_index)];
}

void Pso::io(Archive& a) {
  a.all(armed, output, masked, window, mode, fixed_counts, increments, window_low_mm, window_high_mm,
        next_index, next_counts, pulses, travel_mm, toggle, vector, terminal);
}

void StageDevice::power_on() {
  at_mm_ = {};
  move_.reset();
  track_.reset();
  current_ = {};
  queue_.clear();
  enabled_ = homed_ = {};
  faults_ = {};
  absolute_ = false;
  ramp_mm_s2_ = params_.ramp_rate_mm_s2;
  scurve_percent_ = params_.scurve_percent;
  pso_ = {};
  next_pulse_ = {};
  in_position_us_ = 0;
  sample_period_us_ = 0.0;
  iglobals_.fill(0.0);
  std::ranges::fill(dglobals_, 0.0);
  if (tripped_) faults_.fill(kFaultEstop);
}

StageDevice::Answer StageDevice::enable(int axis) {
  if (faults_[axis] != 0 || refuses_enable_) return Answer::kFault;
  enabled_[axis] = true;
  return Answer::kOk;
}

void StageDevice::disable(int axis, std::int64_t now_us) {
  enabled_[axis] = false;
  if (moving() && (current_.axes >> axis & 1u)) brake(now_us);
}

void StageDevice::fault_acknowledge(int axis) { faults_[axis] = tripped_ ? kFaultEstop : 0; }

void StageDevice::abort(std::int64_t now_us) {
  if (moving()) wires_.note(now_us, Port::kStage, DeviceEvent::kStageAborted, 0);
  brake(now_us);
}

StageDevice::Answer StageDevice::linear(const Vec3& target_mm, double speed_mm_s, std::int64_t now_us) {
  if (!(speed_mm_s > 0.0) || !std::isfinite(speed_mm_s)) return Answer::kNak;
  if (queue_.size() >= kQueueLimit) return Answer::kNak;
  Target target{target_mm, std::min(speed_mm_s, params_.max_speed_mm_s), 0, 0};
  for (int a = 0; a < 3; ++a) {
    if (std::isnan(target_mm[a])) continue;
    if (faults_[a] != 0 || !enabled_[a]) return Answer::kFault;
    target.axes |= 1u << a;
  }
  if (target.axes == 0) return Answer::kNak;
  // The limits are the controller's: it accepts the command and stops with a fault.
  for (int a = 0; a < 3; ++a) {
    if (target_mm[a] > params_.high_limit_mm[a]) {
      raise(a, kFaultHighLimit, now_us);
      return Answer::kOk;
    }
    if (target_mm[a] < params_.low_limit_mm[a]) {
      raise(a, kFaultLowLimit, now_us);
      return Answer::kOk;
    }
  }
  queue_.push_back(target);
  if (!moving()) begin_next(now_us);
  return Answer::kOk;
}

StageDevice::Answer StageDevice::linear_by(const Vec3& step_mm, double speed_mm_s, std::int64_t now_us) {
  Vec3 target = step_mm;
  for (int a = 0; a < 3; ++a) {
    double from = at_mm_[a];
    if (move_ && !std::isnan(current_.mm[a])) from = current_.mm[a];
    for (const Target& t : queue_)
      if (!std::isnan(t.mm[a])) from = t.mm[a];
    target[a] += from;
  }
  return linear(target, speed_mm_s, now_us);
}

StageDevice::Answer StageDevice::home_by_program(std::int64_t now_us) {
  const double axis = iglobals_[33];
  if (iglobals_[32] != 1.0 || !(axis >= 0.0 && axis < 3.0)) return Answer::kFault;
  homed_[std::size_t(axis)] = false;
  program_broken_ = program_breaks_;
  if (program_broken_) return Answer::kOk;
  return home(1u << unsigned(axis), now_us);
}

int StageDevice::task_state() const { return program_broken_ ? 6 : move_ && current_.homing ? 3 : 1; }

void StageDevice::stop_program(std::int64_t now_us) {
  if (move_ && current_.homing) abort(now_us);
}

Vec3 StageDevice::position_mm(std::int64_t now_us) const {
  if (track_) {
    const auto p = track_->position(now_us);
    return {p[0], p[1], at_mm_[2]};
  }
  return move_ ? move_->position(now_us) : at_mm_;
}

double StageDevice::velocity_mm_s(int axis, std::int64_t now_us) const {
  if (track_) return axis < 2 ? track_->velocity(now_us)[std::size_t(axis)] : 0.0;
  return move_ ? move_->speed_mm_s(now_us) * move_->direction()[axis] : 0.0;
}

// Numbers of the EPICS headers. The soft limits are on.
std::optional<double> StageDevice::parameter(int axis, int number) const {
  switch (number) {
    case 2:
      return params_.counts_per_mm;
    case 37:
      return params_.low_limit_mm[std::size_t(axis)];
    case 38:
      return params_.high_limit_mm[std::size_t(axis)];
    case 124:
      return params_.global_integers;
    case 210:
      return 1.0;
  }
  return std::nullopt;
}

StageDevice::Answer StageDevice::home(unsigned axes, std::int64_t now_us) {
  for (int a = 0; a < 3; ++a) {
    if (!(axes >> a & 1u)) continue;
    if (faults_[a] != 0 || !enabled_[a]) return Answer::kFault;
    if (queue_.size() >= kQueueLimit) return Answer::kNak;
    Vec3 target{NAN, NAN, NAN};
    target[a] = 0.0;
    queue_.push_back({target, params_.home_speed_mm_s, 1u << a, 1u << a});
  }
  if (!moving()) begin_next(now_us);
  return Answer::kOk;
}

bool StageDevice::set_ramp(double rate_mm_s2) {
  if (!(rate_mm_s2 >= 1.0 && rate_mm_s2 <= 1e6)) return false;
  ramp_mm_s2_ = rate_mm_s2;
  return true;
}

bool StageDevice::set_scurve(double percent) {
  if (!(percent >= 0.0 && percent <= 100.0)) return false;
  scurve_percent_ = percent;
  return true;
}

StageDevice::Answer StageDevice::arm(int axis, std::int64_t now_us) {
  Pso& p = pso_[axis];
  if (p.mode == Pso::Mode::kNone || (p.mode == Pso::Mode::kFixed && p.fixed_counts < 1))
    return Answer::kFault;
  p.arm();
  if (move_) p.travel_mm = -std::abs(move_->direction()[axis]) * move_->travelled_mm(now_us);
  wires_.note(now_us, Port::kStage, DeviceEvent::kPsoArmed, axis);
  find_pulse();
  return Answer::kOk;
}

void StageDevice::pso_off(int axis, std::int64_t now_us) {
  if (pso_[axis].armed) wires_.note(now_us, Port::kStage, DeviceEvent::kPsoOff, axis);
  pso_[axis].armed = false;
  find_pulse();
}

std::uint32_t StageDevice::axis_status(int axis, std::int64_t now_us) const {
  bool active = moving() && (current_.axes >> axis & 1u), homing = move_ && (current_.homing >> axis & 1u);
  for (const Target& t : queue_) {
    active |= t.axes >> axis & 1u;
    homing |= t.homing >> axis & 1u;
  }
  return (enabled_[axis] ? kEnabled : 0) | (homed_[axis] ? kHomed : 0) |
         (enabled_[axis] && !active && now_us >= in_position_us_ ? kInPosition : 0) |
         (active ? kMoveActive : 0) | (homing ? kHoming : 0) | (tripped_ ? kEstopInput : 0);
}

std::int64_t StageDevice::encoder_counts(int axis, double position_mm) const {
  return std::llround(position_mm * params_.counts_per_mm);
}

std::int64_t StageDevice::next_us() const {
  if (track_) return std::min({track_->end_us(), track_->fault_us(), next_pulse_.t_us});
  return move_ ? std::min(move_->end_us(), next_pulse_.t_us) : kNever;
}

void StageDevice::put_out_pulse(std::int64_t now_us) {
  const int axis = next_pulse_.axis;
  Pso& p = pso_[axis];
  const double s = next_pulse_.s_mm;
  double position[3], velocity[3];
  if (track_) {
    const Vec3 at = position_mm(now_us);
    for (int a = 0; a < 3; ++a) {
      position[a] = at[std::size_t(a)];
      velocity[a] = velocity_mm_s(a, now_us);
    }
  } else {
    const double v = move_->speed_at_s(s);
    for (int a = 0; a < 3; ++a) {
      position[a] = move_->from()[a] + move_->direction()[a] * s;
      velocity[a] = move_->direction()[a] * v;
    }
  }
  const bool inside =
      !p.masked || (p.window && position[axis] >= p.window_low_mm && position[axis] <= p.window_high_mm);
  p.advance();
  find_pulse();
  if (!p.output || !inside || mute_) return;
  ++p.pulses;
  if (params_.terminal_needed && !p.terminal) return;
  wires_.pulse(axis, now_us, position, velocity);
}

void StageDevice::event(std::int64_t now_us) {
  if (!moving()) return;
  if (next_pulse_.t_us <= now_us) return put_out_pulse(now_us);
  if (track_ && now_us < track_->end_us()) return raise(track_->fault_axis(), kFaultPosition, now_us);
  if (track_) {
    end_track(now_us);
  } else {
    const std::uint32_t homing = current_.homing;
    end_move();
    for (int a = 0; a < 3; ++a)
      if (homing >> a & 1u) {
        homed_[a] = true;
        at_mm_[a] = 0.0;
      }
  }
  begin_next(now_us);
  if (!moving()) wires_.note(now_us, Port::kStage, DeviceEvent::kStageStopped, 0);
}

void StageDevice::begin_next(std::int64_t now_us) {
  while (!queue_.empty()) {
    current_ = queue_.front();
    queue_.pop_front();
    if (stuck_ && current_.axes & 1u) return raise(0, kFaultPosition, now_us);
    Vec3 to = at_mm_;
    for (int a = 0; a < 3; ++a)
      if (!std::isnan(current_.mm[a])) to[a] = current_.mm[a];
    // An S-shaped ramp of the same largest acceleration lasts longer by its share; here its mean acts
    // throughout.
    const double ramp_mm_s2 = ramp_mm_s2_ / (1.0 + 0.01 * scurve_percent_);
    move_ = Move::trapezoid(at_mm_, to, current_.speed_mm_s, ramp_mm_s2, now_us);
    if (move_->length_mm() > 0.0) {
      wires_.note(now_us, Port::kStage, DeviceEvent::kStageMoving, 0);
      find_pulse();
      return;
    }
    for (int a = 0; a < 3; ++a)
      if (current_.homing >> a & 1u) homed_[a] = true;
    move_.reset();
  }
  find_pulse();
}

// A finished or broken-off move leaves its travel with the pulse outputs. A finished one ends on its target
// exactly.
void StageDevice::end_move() {
  const Move& m = *move_;
  for (int a = 0; a < 3; ++a) pso_[a].travel_mm += std::abs(m.direction()[a]) * m.length_mm();
  Vec3 end = m.position(m.end_us());
  for (int a = 0; a < 3; ++a)
    if (!std::isnan(current_.mm[a])) end[a] = current_.mm[a];
  at_mm_ = end;
  in_position_us_ = m.end_us() + params_.settle_us;
  move_.reset();
}

void StageDevice::brake(std::int64_t now_us) {
  queue_.clear();
  if (track_) {
    const auto v = track_->velocity(now_us);
    const double speed = std::hypot(v[0], v[1]);
    leave_track(now_us);
    current_.mm = {NAN, NAN, NAN};
    const Vec3 direction = speed > 0.0 ? Vec3{v[0] / speed, v[1] / speed, 0.0} : Vec3{};
    move_ = Move::stop(at_mm_, direction, speed, params_.abort_rate_mm_s2, now_us);
    return find_pulse();
  }
  if (!move_) return;
  const Move m = *move_;
  const double s = m.travelled_mm(now_us);
  for (int a = 0; a < 3; ++a) pso_[a].travel_mm += std::abs(m.direction()[a]) * s;
  at_mm_ = m.position(now_us);
  current_.mm = {NAN, NAN, NAN};
  current_.homing = 0;
  move_ = Move::stop(at_mm_, m.direction(), m.speed_mm_s(now_us), params_.abort_rate_mm_s2, now_us);
  find_pulse();
}

void StageDevice::raise(int axis, std::uint32_t bits, std::int64_t now_us) {
  faults_[axis] |= bits;
  wires_.note(now_us, Port::kStage, DeviceEvent::kStageFault, std::int64_t(faults_[axis]));
  brake(now_us);
}

// The earliest crossing of the move in progress, exactly: s at which an armed axis has travelled its next
// count.
void StageDevice::find_pulse() {
  next_pulse_ = {};
  if (track_) return find_switch();
  if (!move_) return;
  for (int a = 0; a < 3; ++a) {
    const Pso& p = pso_[a];
    const double share = std::abs(move_->direction()[a]);
    if (p.exhausted() || share < 1e-9) continue;
    double s = (double(p.next_counts) / params_.counts_per_mm - p.travel_mm) / share;
    if (s > move_->length_mm() + 1e-7) continue;  // a tenth of a nanometre is rounding
    s = std::clamp(s, 0.0, move_->length_mm());
    const std::int64_t t_us = move_->start_us() + std::llround(move_->time_of_s(s) * 1e6);
    if (t_us < next_pulse_.t_us) next_pulse_ = {t_us, a, s};
  }
}

void StageDevice::find_switch() {
  const Pso& p = pso_[0];
  if (p.exhausted() || !p.vector) return;
  const double s = double(p.next_counts) / params_.counts_per_mm - p.travel_mm;
  const Track& way = track_->counted();
  if (s > way.length_mm() + 1e-7) return;
  const double at_mm = std::clamp(s, 0.0, way.length_mm());
  next_pulse_ = {way.start_us() + std::llround(way.time_of_s(at_mm) * 1e6), 0, at_mm};
}

void StageDevice::link_lost(std::int64_t now_us) {
  if (!moving() && !pso_[0].toggle) return;
  wires_.note(now_us, Port::kStage, DeviceEvent::kStageWatchdog, 0);
  for (int a = 0; a < 3; ++a) pso_off(a, now_us);
  brake(now_us);
}

void StageDevice::trip(bool on, std::int64_t now_us) {
  tripped_ = on;
  if (!on) return;
  for (int a = 0; a < 3; ++a) {
    pso_off(a, now_us);
    raise(a, kFaultEstop, now_us);
    enabled_[a] = false;
  }
}

void StageDevice::stick(bool on, std::int64_t now_us) {
  stuck_ = on;
  if (!on || !moving() || !(current_.axes & 1u)) return;
  at_mm_ = position_mm(now_us);
  if (track_) leave_track(now_us);
  move_.reset();
  raise(0, kFaultPosition, now_us);
}

void StageDevice::lose_count() {
  for (Pso& pso : pso_) pso.pulses = 0;
}

void StageDevice::io(Archive& a) {
  bool moving = move_.has_value(), tracking = track_.has_value();
  Move m = moving ? *move_ : Move{};
  PathFollower t = tracking ? *track_ : PathFollower{};
  bool frozen = frozen_x_mm_.has_value();
  double frozen_mm = frozen_x_mm_.value_or(0.0);
  a.all(at_mm_, moving, m, current_, queue_, enabled_, homed_, faults_, tripped_, ramp_mm_s2_,
        scurve_percent_, stuck_, refuses_enable_, mute_, crossed_, absolute_);
  for (Pso& p : pso_) a(p);
  a(iglobals_);
  a.all(dglobals_, tracking, t, jammed_, program_breaks_, program_broken_, drags_, frozen, frozen_mm,
        in_position_us_, sample_period_us_, sample_first_);
  if (!a.loading()) return;
  move_ = moving ? std::optional<Move>(m) : std::nullopt;
  track_ = tracking ? std::optional<PathFollower>(std::move(t)) : std::nullopt;
  frozen_x_mm_ = frozen ? std::optional<double>(frozen_mm) : std::nullopt;
  find_pulse();
}

}  // namespace firn::plant
