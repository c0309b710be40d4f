#include "plant/twins/grbl.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "core/options/enumerators.h"
#include "core/options/number.h"

namespace firn::plant {
namespace {

constexpr std::int64_t kTick_us = 1000;  // of the stepper's segments
constexpr std::size_t kPlanner = 16, kLongestLine = 80;
constexpr double kMaxPower = 1000.0, kSameDirection = 1.0 - 1e-9;
constexpr char kWelcomeLine[] = "Grbl 1.1h ['$' for help]";

std::string numbers(const Vec3& v) {
  char text[80];
  std::snprintf(text, sizeof text, "%.3f,%.3f,%.3f", v[0], v[1], v[2]);
  return text;
}

}  // namespace

GrblTwin::GrblTwin(const StageParams& params, Wires& wires)
    : Twin(Port::kStage, TwinLink(10.0 / params.baud * 1e6, params.latency_us)),
      params_(params),
      wires_(wires) {}

Vec3 GrblTwin::place() const {
  Vec3 p = from_mm_;
  for (std::size_t a = 0; a < 3; ++a) p[a] += direction_[a] * done_mm_;
  return p;
}

// Between two ticks the speed is taken as even.
Vec3 GrblTwin::position_mm(std::int64_t now_us) const {
  Vec3 p = place();
  const double ahead_mm =
      moving() ? std::min(speed_mm_s_ * double(std::max<std::int64_t>(0, now_us - last_us_)) * 1e-6,
                          length_mm_ - done_mm_)
               : 0.0;
  for (std::size_t a = 0; a < 3; ++a) p[a] += direction_[a] * ahead_mm;
  return p;
}

double GrblTwin::velocity_mm_s(int axis, std::int64_t) const {
  return speed_mm_s_ * direction_[std::size_t(axis)];
}

std::int64_t GrblTwin::encoder_counts(int, double position_mm) const {
  return std::llround(position_mm * params_.counts_per_mm);
}

void GrblTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (c == '?' || c == '!' || c == '~' || c == '\x18') {
      real_time(c, now_us);
    } else if (c == '\n' || c == '\r') {
      if (!line_.empty()) lines_.push_back(std::move(line_));
      line_.clear();
      advance(now_us);
      interpret(now_us);
    } else if (line_.size() <= kLongestLine) {
      line_ += c;
    }
  }
}

void GrblTwin::real_time(char byte, std::int64_t now_us) {
  advance(now_us);
  switch (byte) {
    case '?':
      return report(now_us);
    case '!':
      if (state_ == State::kRunning) state_ = State::kHolding;
      if (state_ == State::kIdle) state_ = State::kHeld;
      return;
    case '~':
      if (state_ == State::kHeld || state_ == State::kHolding)
        state_ = blocks_.empty() ? State::kIdle : State::kRunning;
      last_us_ = now_us;
      return interpret(now_us);
    default:
      return reset(now_us);
  }
}

void GrblTwin::reset(std::int64_t now_us) {
  const bool lost = moving();
  switch_output(false, now_us);
  spindle_ = coolant_ = false;
  from_mm_ = goal_mm_ = place();
  direction_ = {};
  length_mm_ = done_mm_ = speed_mm_s_ = 0.0;
  blocks_.clear();
  lines_.clear();
  line_.clear();
  power_ = feed_mm_s_ = 0.0;
  if (lost) {
    wires_.note(now_us, Port::kStage, DeviceEvent::kStageAborted, 0);
    say("ALARM:3", now_us);
  }
  if (lost || state_ == State::kAlarm)
    state_ = State::kAlarm;
  else if (state_ != State::kDoor)
    state_ = State::kIdle;
  say("", now_us);
  say(kWelcomeLine, now_us);
  if (state_ == State::kAlarm) say("[MSG:'$H'|'$X' to unlock]", now_us);
}

void GrblTwin::alarm(int number, std::int64_t now_us) {
  reset(now_us);
  state_ = State::kAlarm;
  say("ALARM:" + std::to_string(number), now_us);
}

void GrblTwin::report(std::int64_t now_us) {
  static constexpr const char* kWords[] = {"Idle", "Run", "Hold:1", "Hold:0", "Alarm", "Home", "Door:0"};
  static_assert(std::size(kWords) == kTableSize<State>);
  char rest[80];
  std::snprintf(rest, sizeof rest, "|FS:%.0f,%.0f|WCO:0.000,0.000,0.000>", speed_mm_s_ * 60.0,
                output_ ? kMaxPower : 0.0);
  say("<" + std::string(kWords[int(state_)]) + "|MPos:" + numbers(position_mm(now_us)) + rest, now_us);
}

void GrblTwin::interpret(std::int64_t now_us) {
  while (!lines_.empty()) {
    const std::string answer = execute(lines_.front(), now_us);
    if (answer.empty()) return;
    if (lines_.empty()) return;  // an alarm has emptied them
    lines_.pop_front();
    say(answer, now_us);
  }
}

std::string GrblTwin::settings() const {
  const auto n = [](const char* name, double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%s=%.3f\r\n", name, value);
    return std::string(text);
  };
  const double steps = params_.counts_per_mm * (other_board_ ? 0.5 : 1.0);
  std::string all = "$10=1\r\n$13=0\r\n$20=1\r\n$22=1\r\n$30=1000\r\n$32=1\r\n";
  for (const char* axis : {"$100", "$101", "$102"}) all += n(axis, steps);
  for (const char* axis : {"$110", "$111", "$112"}) all += n(axis, params_.max_speed_mm_s * 60.0);
  for (const char* axis : {"$120", "$121", "$122"}) all += n(axis, params_.ramp_rate_mm_s2);
  return all + "ok";
}

std::string GrblTwin::execute(std::string_view line, std::int64_t now_us) {
  if (line.starts_with('$')) {
    if (line == "$X") {
      if (state_ == State::kAlarm) state_ = State::kIdle;
      return "ok";
    }
    if (line == "$I") return "[VER:1.1h.20190825:twin]\r\n[OPT:V,15,128]\r\nok";
    if (state_ != State::kIdle && state_ != State::kAlarm) return "error:8";
    if (line == "$$") return settings();
    if (line != "$H") return "error:3";
    double away_mm = 0.0;
    for (const double mm : place()) away_mm = std::max(away_mm, std::abs(mm));
    state_ = State::kHoming;
    homed_us_ = now_us + std::int64_t(away_mm / params_.home_speed_mm_s * 1e6) + kTick_us;
    return "";  // answered when it is home
  }
  if (state_ == State::kHoming) return "";
  if (state_ == State::kAlarm || state_ == State::kDoor) return "error:9";
  return g_code(line, now_us);
}

std::string GrblTwin::g_code(std::string_view line, std::int64_t) {
  Vec3 target = goal_mm_;
  double feed = feed_mm_s_, power = power_;
  bool axes = false;
  int spindle = -1, coolant = -1;
  while (!line.empty()) {
    if (line.front() == ' ') {
      line.remove_prefix(1);
      continue;
    }
    const char letter = line.front();
    line.remove_prefix(1);
    const std::optional<double> value = take_number<double>(line, Exponent::kLeft);
    if (!value) return "error:2";
    if (letter >= 'X' && letter <= 'Z') {
      target[std::size_t(letter - 'X')] = *value;
      axes = true;
    } else if (letter == 'F') {
      feed = *value / 60.0;
    } else if (letter == 'S') {
      power = *value;
    } else if (letter == 'M' && (*value == 3 || *value == 4 || *value == 5)) {
      spindle = *value == 5 ? 0 : 1;
    } else if (letter == 'M' && (*value == 8 || *value == 9)) {
      coolant = *value == 9 ? 0 : 1;
    } else if (!(letter == 'G' &&
                 (*value == 1 || *value == 21 || *value == 90 || *value == 94 || *value == 54))) {
      return "error:20";
    }
  }
  // A change of these waits until the planner is empty.
  if ((spindle >= 0 || coolant >= 0) && !blocks_.empty()) return "";
  if (axes) {
    if (!(feed > 0.0)) return "error:22";
    if (blocks_.size() >= kPlanner || state_ == State::kHolding || state_ == State::kHeld) return "";
  }
  feed_mm_s_ = feed;
  power_ = power;
  if (spindle >= 0) spindle_ = spindle == 1;
  if (coolant >= 0 && (coolant == 1) != coolant_) {
    coolant_ = coolant == 1;
    box_mm_ = 0.0;
    box_pulses_ = 0;
  }
  if (!axes || target == goal_mm_) return "ok";
  for (std::size_t a = 0; a < 3; ++a)
    if (target[a] > params_.high_limit_mm[a] || target[a] < params_.low_limit_mm[a]) {
      alarm(2, last_us_);
      return "";
    }
  goal_mm_ = target;
  blocks_.push_back({target, std::min(feed, params_.max_speed_mm_s), spindle_ ? power : 0.0});
  if (blocks_.size() == 1) {
    from_mm_ = place();
    done_mm_ = speed_mm_s_ = 0.0;
    state_ = State::kRunning;
    begin_block(last_us_);
  }
  return "ok";
}

void GrblTwin::begin_block(std::int64_t t_us) {
  const Block& b = blocks_.front();
  length_mm_ = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    direction_[a] = b.to_mm[a] - from_mm_[a];
    length_mm_ += direction_[a] * direction_[a];
  }
  length_mm_ = std::sqrt(length_mm_);
  for (double& d : direction_) d /= length_mm_;
  done_mm_ = 0.0;
  switch_output(b.power > 0.0, t_us);
}

void GrblTwin::switch_output(bool on, std::int64_t t_us) {
  if (on && !output_ && !mute_ && params_.laser_output) {
    const Vec3 p = place();
    const double velocity[3] = {velocity_mm_s(0, t_us), velocity_mm_s(1, t_us), velocity_mm_s(2, t_us)};
    wires_.pulse(0, t_us, p.data(), velocity);
  }
  output_ = on;
}

/// The way ahead on which it need not slow down for a corner.
double GrblTwin::collinear_mm() const {
  double mm = length_mm_ - done_mm_;
  for (std::size_t n = 1; n < blocks_.size(); ++n) {
    const Vec3 &a = blocks_[n - 1].to_mm, &b = blocks_[n].to_mm;
    double squared = 0.0, along = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      squared += (b[k] - a[k]) * (b[k] - a[k]);
      along += (b[k] - a[k]) * direction_[k];
    }
    const double length = std::sqrt(squared);
    if (along < kSameDirection * length) break;
    mm += length;
  }
  return mm;
}

void GrblTwin::travel(double mm, std::int64_t from_us, std::int64_t to_us) {
  const double whole = mm;
  while (mm > 0.0 && !blocks_.empty()) {
    const double step = std::min(mm, length_mm_ - done_mm_);
    const double y0 = place()[1];
    done_mm_ += step;
    mm -= step;
    const auto t_at = [&](double left) {
      return from_us + std::int64_t(double(to_us - from_us) * (whole > 0.0 ? (whole - left) / whole : 1.0));
    };
    if (coolant_ && params_.box_pitch_mm > 0.0) {
      box_mm_ += std::abs(place()[1] - y0);
      while (box_mm_ >= double(box_pulses_ + 1) * params_.box_pitch_mm - 1e-9) {
        ++box_pulses_;
        Vec3 p = place();
        p[1] -= (direction_[1] >= 0.0 ? 1.0 : -1.0) * (box_mm_ - double(box_pulses_) * params_.box_pitch_mm);
        const double velocity[3] = {velocity_mm_s(0, to_us), velocity_mm_s(1, to_us),
                                    velocity_mm_s(2, to_us)};
        wires_.pulse(1, t_at(mm), p.data(), velocity);
      }
    }
    if (length_mm_ - done_mm_ > 1e-12) return;
    from_mm_ = blocks_.front().to_mm;
    done_mm_ = 0.0;
    blocks_.pop_front();
    if (blocks_.empty()) {
      length_mm_ = 0.0;
      direction_ = {};
      return switch_output(false, t_at(mm));
    }
    begin_block(t_at(mm));
  }
}

void GrblTwin::advance(std::int64_t now_us) {
  if (state_ != State::kRunning && state_ != State::kHolding) last_us_ = std::max(last_us_, now_us);
  while (last_us_ < now_us) {
    const std::int64_t to_us = std::min(now_us, last_us_ + kTick_us);
    const double dt_s = double(to_us - last_us_) * 1e-6;
    if ((state_ == State::kRunning || state_ == State::kHolding) && !blocks_.empty()) {
      const double a = params_.ramp_rate_mm_s2, left_mm = collinear_mm();
      const double wanted =
          state_ == State::kHolding ? 0.0 : std::min(blocks_.front().feed_mm_s, std::sqrt(2.0 * a * left_mm));
      const double v = std::clamp(wanted, std::max(0.0, speed_mm_s_ - a * dt_s), speed_mm_s_ + a * dt_s);
      // The last bit of a ramp is so slow that it would never end.
      double mm = 0.5 * (v + speed_mm_s_) * dt_s;
      if (state_ == State::kRunning && left_mm - mm < 0.5 * a * dt_s * dt_s) mm = left_mm;
      speed_mm_s_ = v;
      travel(std::min(mm, left_mm), last_us_, to_us);
      if (state_ == State::kHolding && speed_mm_s_ <= 0.0) {
        state_ = State::kHeld;
        switch_output(false, to_us);  // DISABLE_LASER_DURING_HOLD
      }
      if (blocks_.empty()) {
        speed_mm_s_ = 0.0;
        state_ = state_ == State::kHolding ? State::kHeld : State::kIdle;
      }
    } else if (state_ == State::kHolding) {
      state_ = State::kHeld;
    }
    last_us_ = to_us;
  }
}

std::int64_t GrblTwin::next_device_us() const {
  if (state_ == State::kHoming) return homed_us_;
  return state_ == State::kRunning || state_ == State::kHolding ? last_us_ + kTick_us : kNever;
}

void GrblTwin::device_event(std::int64_t now_us) {
  if (state_ == State::kHoming && now_us >= homed_us_) {
    from_mm_ = goal_mm_ = {};
    state_ = State::kIdle;
    last_us_ = now_us;
    if (!lines_.empty()) lines_.pop_front();
    say("ok", now_us);
  }
  advance(now_us);
  interpret(now_us);
}

void GrblTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  switch_output(false, now_us);
  spindle_ = coolant_ = false;
  from_mm_ = goal_mm_ = place();
  direction_ = {};
  length_mm_ = done_mm_ = speed_mm_s_ = power_ = feed_mm_s_ = 0.0;
  blocks_.clear();
  lines_.clear();
  line_.clear();
  state_ = State::kAlarm;
  say(kWelcomeLine, now_us);
  say("[MSG:'$H'|'$X' to unlock]", now_us);
}

void GrblTwin::trip(std::int64_t now_us, std::int64_t code) {
  advance(now_us);
  mute_ = code == 3;
  other_board_ = code == 4;
  if (code == 1) alarm(1, now_us);
  if (code == 2) {
    reset(now_us);
    state_ = State::kDoor;
  }
  if (code == 0 && state_ == State::kDoor) state_ = State::kIdle;
}

void GrblTwin::io(Archive& a) {
  a.all(state_, line_, lines_, blocks_, from_mm_, direction_, length_mm_, done_mm_, speed_mm_s_, last_us_,
        homed_us_, goal_mm_, feed_mm_s_, power_, spindle_, coolant_, output_, box_mm_, box_pulses_, mute_,
        other_board_, boot_count_);
  link_.io(a);
}

}  // namespace firn::plant
