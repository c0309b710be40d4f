#include "drivers/laser_profiler/point_scan.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace firn::drivers {
namespace {

constexpr std::int64_t kMode_us = 3'000'000;  // R0 takes its time
constexpr std::int64_t kLate_us = 100'000;    // an averaged value comes so long after its pulse at most
constexpr int kStatusError = 1, kMostOfSwath = 1'000'000;

std::string_view reply_line(std::span<const std::byte> frame) {
  return text_of(frame.first(frame.size() - 1));
}

std::string asked(const Request& r) { return "'" + std::string(r.text().substr(0, r.size - 1u)) + "'"; }

}  // namespace

PointScan::PointScan(LaserProfilerOptions config, PointScanPlace place)
    : ProfilerDriver(dialect_),
      config_(config),
      place_(place),
      silence_(std::int64_t(config.poll_idle_s * 1e6), dialect_) {
  identity_ = "Keyence LK-G3001P";
  check_options("laser_profiler", kLaserProfilerConfig, config_);
  dialect_.allow_host_latency(config.host_latency_s);
}

void PointScan::service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
                        Effects& fx) {
  Service s{std::string(verb), {}, 0, {}, nullptr};
  if (verb == "serial" && values.empty()) {  // the program is a setting: only the model tells who it is
    fx.events.emplace_back(
        Result{Outcome::kDone, -1, 0, 0, 0, kNoCode, identity_.substr(0, identity_.find(','))});
    return;
  }
  if (verb != "read" || !values.empty()) return Driver::service(verb, values, now_us, fx);
  s.begin = {lkg::request("M1", Repeat::kRead, kValue)};
  s.tell = [this](const Request& request, std::span<const std::byte> frame) -> std::optional<std::string> {
    const lkg::Reply r = lkg::parse(reply_line(frame), request.text().substr(0, request.size - 1u));
    if (r.kind != lkg::Reply::Kind::kDone) return std::nullopt;
    read_mm_ = lkg::parse_value(r.rest).mm;
    return std::string();
  };
  s.then = [this](std::int64_t, Effects& effects) {
    effects.measured<PointScan>(row_of(0, read_mm_));
    effects.events.emplace_back(Result{Outcome::kDone, 1, 1, 0, 0, kNoCode, "1 point"});
  };
  run_service(std::move(s));
}

void PointScan::connected(std::int64_t, Effects& fx) {
  set_state(DeviceState::kIdentifying, identity_, fx);
  phase_ = Phase::kIdentifying;
  // It may have been left in communication mode, where it measures nothing.
  link_.push(lkg::request("R0", Repeat::kSetup, kLeave, kMode_us));
  link_.push(lkg::request("PW," + std::to_string(config_.program), Repeat::kSetup, kPlain));
  ask_program();
}

void PointScan::refuse(int rows, std::int32_t code, std::string text, Effects& fx) {
  fx.events.emplace_back(Result{Outcome::kRefused, -1, rows, 0, 0, code, std::move(text)});
}

void PointScan::finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx) {
  op_ = Op::kNone;
  fx.events.emplace_back(Result{outcome, received_, rows_, 0, 0, code, std::move(text)});
}

bool PointScan::accepts(bool armed_too, int rows, Effects& fx) {
  if (!busy() && (phase_ == Phase::kReady || (armed_too && phase_ == Phase::kArmed))) return true;
  refuse(rows, kNoCode,
         busy() ? "the laser is busy with another command" : std::string("the laser is ") + standing(), fx);
  return false;
}

void PointScan::arm(int rows, std::int64_t now_us, Effects& fx) {
  if (accepts(false, rows, fx)) {
    if (rows < 1 || rows > kMostOfSwath) {
      refuse(rows, kLimit, "a scan of " + std::to_string(rows) + " rows", fx);
    } else {
      op_ = Op::kArm;
      phase_ = Phase::kArming;
      rows_ = rows;
      received_ = 0;
      mm_.clear();
      whole_ = true;
      ask_program();
      set_state(DeviceState::kStaged, "arming", fx);
    }
  }
  pump(now_us, fx);
}

void PointScan::end(std::int64_t now_us, Effects& fx) {
  if (accepts(true, 0, fx)) {
    op_ = Op::kEnd;
    phase_ = Phase::kEnding;
    questions_ = 0;
  }
  pump(now_us, fx);
}

void PointScan::stop(std::int64_t, Effects& fx) {  // it moves, fires and lights nothing that could harm
  if (phase_ == Phase::kDown || phase_ == Phase::kIdentifying) return;
  link_.clear_queue();
  scan_over(fx);
  if (busy()) finish(op_ == Op::kArm ? Outcome::kNone : Outcome::kDone, kNoCode, "safe stop", fx);
  phase_ = Phase::kReady;
  set_state(DeviceState::kSafe, "stopped", fx);
}

void PointScan::lost(std::int64_t, Effects& fx) {
  if (phase_ == Phase::kDown) return;
  if (scanning_ || busy())
    fault(Severity::kWarning, kLinkLost, "laser_profiler: link lost during a scan", fx);
  whole_ = false;
  phase_ = Phase::kDown;
}

void PointScan::failed(const Request& request, std::int64_t now_us, Effects& fx) {
  reconnect(now_us, fx, "no good reply to " + asked(request) + not_understood());
}

ProfileRow PointScan::row_of(std::int32_t row, double value_mm) const {
  const double sign = config_.z_sign == ZSign::kUp ? 1.0 : -1.0;
  ProfileRow p;
  p.row = row;
  p.x0_mm = place_.middle_mm + config_.offset_x_mm;
  p.dx_mm = place_.dx_mm;
  p.trigger_count = std::uint32_t(row) + 1;
  p.by_encoder = false;
  p.z_mm = {float(sign * (value_mm - config_.z_zero_mm))};
  return p;
}

void PointScan::scan_over(Effects& fx) {
  if (!std::exchange(scanning_, false)) return;
  received_ = 0;
  if (whole_ && std::ssize(mm_) == rows_) {
    for (; received_ < rows_; ++received_)
      fx.measured<PointScan>(row_of(received_, double(mm_[std::size_t(received_)])));
  } else if (whole_) {
    fault(Severity::kWarning, kInstrument,
          "laser_profiler: " + std::to_string(mm_.size()) + " values of " + std::to_string(rows_) +
              " pulses: the rows they belong to cannot be told, so none is used",
          fx);
  }
  mm_.clear();
  fx.measured<PointScan>(ScanDone{rows_, received_});
}

void PointScan::unsolicited(std::span<const std::byte> frame, std::int64_t, Effects&) {
  const std::string_view line = reply_line(frame);
  constexpr std::string_view kOutput1 = "TG,1,";
  if (!scanning_ || !line.starts_with(kOutput1)) return;  // the second output has no head
  if (std::ssize(mm_) > rows_) return;                    // too many already
  mm_.push_back(float(lkg::parse_value(line.substr(kOutput1.size())).mm));
}

void PointScan::reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
                      Effects& fx) {
  silence_.heard(now_us);
  const lkg::Reply r = lkg::parse(reply_line(frame), request.text().substr(0, request.size - 1u));
  if (r.kind == lkg::Reply::Kind::kError) {
    if (request.tag == kLeave && r.error == kStatusError) return;  // it measures already
    const std::string why = "the laser answers " + asked(request) + " with error " + std::to_string(r.error);
    fault(Severity::kWarning, kCommandRejected, "laser_profiler: " + why, fx);
    return reconnect(now_us, fx, why);
  }
  if (request.tag != kProgram) return;
  identity_ = "Keyence LK-G3001P, program " + std::string(r.rest);
  if (r.rest == std::to_string(config_.program)) return;
  const std::string why = "the laser is in program " + std::string(r.rest) + ", not in " +
                          std::to_string(config_.program);  // changed at its panel
  fault(Severity::kWarning, kInstrument, "laser_profiler: " + why, fx);
  reconnect(now_us, fx, why);
}

bool PointScan::idle(std::int64_t now_us, Effects& fx) {
  switch (phase_) {
    case Phase::kIdentifying:
      identified();
      phase_ = Phase::kReady;
      scan_over(fx);  // values that came meanwhile are gone
      if (busy())
        finish(op_ == Op::kArm ? Outcome::kNone : Outcome::kDone, kLinkLost, "the link was lost", fx);
      set_state(DeviceState::kSafe, "measuring", fx);
      return false;
    case Phase::kArming:
      phase_ = Phase::kArmed;
      scanning_ = true;
      silence_.end();  // nobody asks it before the end of the swath
      set_state(DeviceState::kArmed, "waiting for triggers", fx);
      finish(Outcome::kReady, kNoCode, {}, fx);
      return false;
    case Phase::kEnding:
      // Its answer comes behind the values that it has sent.
      if (questions_ == 0 || (questions_ == 1 && scanning_ && std::ssize(mm_) < rows_)) {
        if (questions_ == 1 && now_us < asked_us_ + kLate_us) return false;
        ++questions_;
        asked_us_ = now_us;
        ask_program();
        return true;
      }
      scan_over(fx);
      phase_ = Phase::kReady;
      set_state(DeviceState::kSafe, "scan ended", fx);
      finish(Outcome::kDone, kNoCode, {}, fx);
      return false;
    case Phase::kReady:
      if (now_us < link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6)) return false;
      ask_program();
      return true;
    default:
      return false;
  }
}

void PointScan::tick(std::int64_t now_us, Effects& fx) {
  if (silence_.is_over(now_us)) fault(Severity::kStop, kLinkLost, "laser_profiler: " + silence_.words(), fx);
}

std::int64_t PointScan::device_wake_us() const {
  const std::int64_t silent_us = silence_.wake_us();
  std::int64_t next_us = 0;
  if (link_.idle() && phase_ == Phase::kReady)
    next_us = link_.last_sent_us() + std::int64_t(config_.poll_idle_s * 1e6);
  if (link_.idle() && phase_ == Phase::kEnding) next_us = asked_us_ + kLate_us;
  if (next_us == 0 || silent_us == 0) return std::max(next_us, silent_us);
  return std::min(next_us, silent_us);
}

}  // namespace firn::drivers
