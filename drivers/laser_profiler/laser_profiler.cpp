#include "drivers/laser_profiler/laser_profiler.h"

#include <algorithm>
#include <cstdio>

namespace firn::drivers {
namespace {

constexpr std::uint32_t kMaxUnread = 1u << 20;  // more is a counter that ran backwards

}  // namespace

LaserProfiler::LaserProfiler(LaserProfilerOptions config)
    : ProfilerDriver(dialect_), config_(config), silence_(std::int64_t(config.poll_idle_s * 1e6), dialect_) {
  identity_ = "Keyence LJ-V7000";
  check_options("laser_profiler", kLaserProfilerConfig, config_);
  dialect_.allow_host_latency(config.host_latency_s);
}

void LaserProfiler::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  link_.push(ljv::change_program(config_.program));
  link_.push(ljv::get_newest_profile());
}

void LaserProfiler::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  op_ = Op::kNone;
  fx.events.emplace_back(
      Result{outcome, outcome == Outcome::kRefused ? -1 : received_, rows_, 0, 0, code, std::move(text)});
}

void LaserProfiler::arm(int rows, std::int64_t now_us, Effects& fx) {
  if (busy() || phase_ != Phase::kReady) {
    fx.events.emplace_back(Result{
        Outcome::kRefused, -1, rows, 0, 0, kNoCode,
        busy() ? "the profiler is busy with another command" : std::string("the profiler is ") + standing()});
  } else if (rows < 1 || rows > 1'000'000) {
    fx.events.emplace_back(
        Result{Outcome::kRefused, -1, rows, 0, 0, kLimit, "a scan of " + std::to_string(rows) + " rows"});
  } else {
    op_ = Op::kArm;
    phase_ = Phase::kArming;
    rows_ = rows;
    received_ = 0;
    last_row_us_ = row_us_ = 0;
    link_.push(ljv::get_newest_profile());
    set_state(DeviceState::kStaged, "arming", fx);
  }
  pump(now_us, fx);
}

void LaserProfiler::end(std::int64_t now_us, Effects& fx) {
  if (busy() || (phase_ != Phase::kReady && phase_ != Phase::kArmed)) {
    fx.events.emplace_back(Result{
        Outcome::kRefused, -1, 0, 0, 0, kNoCode,
        busy() ? "the profiler is busy with another command" : std::string("the profiler is ") + standing()});
  } else {
    op_ = Op::kEnd;
    phase_ = Phase::kEnding;
    asked_ = false;
  }
  pump(now_us, fx);
}

void LaserProfiler::stop(std::int64_t, Effects& fx) {  // it moves, fires and lights nothing that could harm
  if (phase_ == Phase::kDown || phase_ == Phase::kIdentifying) return;
  link_.clear_queue();
  scan_over(fx);
  phase_ = Phase::kReady;
  if (busy()) finish(op_ == Op::kArm ? Outcome::kNone : Outcome::kDone, kNoCode, "safe stop", fx);
  set_state(DeviceState::kSafe, "stopped", fx);
}

void LaserProfiler::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (scanning_ || busy())
    fault(Severity::kWarning, kLinkLost, "laser_profiler: link lost during a scan", fx);
  phase_ = Phase::kDown;
}

void LaserProfiler::failed(const Request&, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply" + not_understood());
}

void LaserProfiler::scan_over(Effects& fx) {
  if (!scanning_) return;
  scanning_ = false;
  fx.measured<LaserProfiler>(ScanDone{rows_, received_});
}

// x = offset + mirror * x of the head, z = sign * (z - zero) [docs/devices/laser_profiler.md].
ProfileRow LaserProfiler::in_part_frame(std::uint32_t row) const {
  ProfileRow p{std::int32_t(row),  config_.offset_x_mm + raw_.x0_mm,
               raw_.dx_mm,         raw_.trigger_count,
               raw_.encoder_count, raw_.z_mm};
  if (on(config_.mirror_x)) {
    p.x0_mm = config_.offset_x_mm - (raw_.x0_mm + double(raw_.points - 1) * raw_.dx_mm);
    std::ranges::reverse(p.z_mm);
  }
  if (config_.z_sign != ZSign::kUp || config_.z_zero_mm != 0.0) {
    const double sign = config_.z_sign == ZSign::kUp ? 1.0 : -1.0;
    for (float& z : p.z_mm) z = float(sign * (double(z) - config_.z_zero_mm));
  }
  return p;
}

void LaserProfiler::take(std::int64_t now_us, Effects& fx) {
  if (raw_.points == 0 || raw_.trigger_count == last_trigger_) return;
  last_trigger_ = raw_.trigger_count;
  const std::uint32_t row = raw_.trigger_count - base_trigger_ - 1;  // modulo 2^32, like the counter
  if (row >= std::uint32_t(rows_)) {
    fault(Severity::kWarning, kInstrument,
          "laser_profiler: trigger " + std::to_string(raw_.trigger_count) + " is no row of this scan", fx);
    return;
  }
  if (last_row_us_ != 0 && row > last_row_) {
    const std::int64_t each_us = (now_us - last_row_us_) / std::int64_t(row - last_row_);
    row_us_ = row_us_ == 0 ? each_us : std::min(row_us_, each_us);
  }
  last_row_ = row;
  last_row_us_ = now_us;
  ++received_;
  fx.measured<LaserProfiler>(in_part_frame(row));
  if (row + 1 == std::uint32_t(rows_)) scan_over(fx);
}

bool LaserProfiler::ask_by_number() {
  const std::uint32_t unread = newest_number_ + 1 - next_number_;  // modulo 2^32, like the numbers
  if (unread == 0 || unread > kMaxUnread || asked_number_ == next_number_) return false;
  asked_number_ = next_number_;
  link_.push(ljv::get_profiles(next_number_, int(std::min<std::uint32_t>(unread, ljv::kMaxProfiles))));
  return true;
}

// Rows in the order of their numbers: one that comes too early is asked for when its turn has come.
void LaserProfiler::take_all(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) {
  const auto held = ljv::parse_holdings(frame);
  if (!held) return;
  newest_number_ = held->newest;
  if (held->oldest - next_number_ < kMaxUnread) next_number_ = held->oldest;  // those before are lost
  for (int k = 0; scanning_ && k < held->profiles; ++k) {
    if (held->first + std::uint32_t(k) != next_number_) continue;
    if (!ljv::parse_profile(frame, raw_, k)) return;
    ++next_number_;
    take(now_us, fx);
  }
}

void LaserProfiler::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                          Effects& fx) {
  silence_.heard(now_us);
  const auto head = ljv::parse_head(frame);
  if (head && request.argument == ljv::kGetProfile && head->return_code == ljv::kNoProfile) {
    raw_.points = 0;
  } else if (!head || head->return_code != 0) {
    const std::uint8_t code = head ? head->return_code : std::uint8_t(0);
    const std::string_view why = ljv::return_text(std::uint8_t(request.argument), code);
    char text[160];
    std::snprintf(text, sizeof text, "laser_profiler: command %02X answered with error %02X%s%.*s",
                  unsigned(request.argument), unsigned(code), why.empty() ? "" : ": ", int(why.size()),
                  why.data());
    const bool nothing_yet = request.argument == ljv::kGetProfile && head && !scanning_;
    fault(nothing_yet ? Severity::kNotice : Severity::kWarning, kInstrument, text, fx);
    if (request.argument == ljv::kChangeProgram) return reconnect(now_us, fx, text);
    raw_.points = 0;
  } else if (request.argument == ljv::kGetProfile && !ljv::parse_profile(frame, raw_, 0, false)) {
    fault(
        Severity::kWarning, kInstrument,
        "laser_profiler: a profile of " + std::to_string(frame.size()) + " bytes contradicts its own fields",
        fx);
    raw_.points = 0;
    return;
  }
  if (request.argument != ljv::kGetProfile) return;
  if (scanning_ && (phase_ == Phase::kArmed || phase_ == Phase::kEnding)) {
    if (by_number()) {
      take_all(frame, now_us, fx);
    } else {
      if (raw_.points > 0 && raw_.trigger_count != last_trigger_) ljv::parse_profile(frame, raw_);
      take(now_us, fx);
    }
    if (!scanning_ && phase_ == Phase::kArmed) {
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "scan complete", fx);
    }
  } else {
    last_trigger_ = raw_.points == 0 ? 0 : raw_.trigger_count;
    if (const auto held = ljv::parse_holdings(frame)) newest_number_ = held->newest;
  }
}

bool LaserProfiler::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kIdentifying:
      identified();
      phase_ = Phase::kReady;
      scan_over(fx);  // the rows that came before the link was lost are all there will be
      if (busy())
        finish(op_ == Op::kArm ? Outcome::kNone : Outcome::kDone, kLinkLost, "the link was lost", fx);
      set_state(DeviceState::kSafe, "program " + std::to_string(config_.program), fx);
      return false;
    case Phase::kArming:
      base_trigger_ = last_trigger_;
      next_number_ = newest_number_ + 1;
      phase_ = Phase::kArmed;
      scanning_ = true;
      set_state(DeviceState::kArmed, "waiting for triggers", fx);
      finish(Outcome::kReady, kNoCode, {}, fx);
      return false;
    case Phase::kEnding:
      if (!asked_ && scanning_) {
        link_.push(ljv::get_newest_profile(!by_number()));
        asked_number_.reset();
        return asked_ = true;
      }
      if (by_number() && scanning_ && ask_by_number()) return true;
      scan_over(fx);
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "scan ended", fx);
      finish(Outcome::kDone, kNoCode, {}, fx);
      return false;
    case Phase::kReady:
    case Phase::kArmed:
      if (phase_ == Phase::kArmed && by_number() && ask_by_number()) return true;
      if (now_us < next_poll_us()) return false;
      link_.push(ljv::get_newest_profile(!(by_number() && phase_ == Phase::kArmed)));
      asked_number_.reset();
      return true;
    default:
      return false;
  }
}

std::int64_t LaserProfiler::next_poll_us() const {
  const double period_s = phase_ == Phase::kArmed ? config_.poll_s : config_.poll_idle_s;
  const std::int64_t next_us = link_.last_sent_us() + std::int64_t(period_s * 1e6);
  return phase_ == Phase::kArmed ? std::max(next_us, last_row_us_ + row_us_ * 9 / 10) : next_us;
}

void LaserProfiler::tick(std::int64_t now_us, Effects& fx) {
  if (silence_.is_over(now_us)) fault(Severity::kStop, kLinkLost, "laser_profiler: " + silence_.words(), fx);
}

std::int64_t LaserProfiler::device_wake_us() const {
  const std::int64_t silent_us = silence_.wake_us();
  if (!link_.idle() || (phase_ != Phase::kReady && phase_ != Phase::kArmed)) return silent_us;
  return silent_us == 0 ? next_poll_us() : std::min(next_poll_us(), silent_us);
}

}  // namespace firn::drivers
