#include "drivers/stage/stage.h"

#include <cmath>
#include <cstdio>
#include <limits>

namespace firn::drivers {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr char kAxisNames[] = "XYZ";

RasterParams raster_params(const StageConfig& c, double speed_mm_s) {
  return {speed_mm_s, c.acceleration_mm_s2, c.margin_mm, c.counts_per_mm, c.table.increments()};
}

std::string too_fast(char axis, double speed_mm_s, double limit_mm_s) {
  char text[100];
  std::snprintf(text, sizeof text, "axis %c: speed %.4f mm/s is outside (0, %.4f] mm/s", axis, speed_mm_s,
                limit_mm_s);
  return text;
}

bool in_range(double speed_mm_s, double limit_mm_s) { return speed_mm_s > 0.0 && speed_mm_s <= limit_mm_s; }

}  // namespace

Stage::Stage(StageConfig config) : Driver(dialect_), config_(std::move(config)) {
  dialect_.table = config_.table;
  dialect_.allow_host_latency(config_.host_latency_s);
  identity_ = "Aerotech Ensemble";
  position_mm_.fill(kNaN);
  target_mm_.fill(kNaN);
}

void Stage::refuse(std::int32_t code, std::string text, Effects& fx) {
  Result r;
  r.outcome = Outcome::kRefused;
  r.code = code;
  r.text = std::move(text);
  fx.events.emplace_back(std::move(r));
}

bool Stage::accept(Op op, Effects& fx) {
  if (busy()) return refuse(kNoCode, "the stage is busy with another command", fx), false;
  if (op == Op::kHome && phase_ == Phase::kDead && link_.idle()) return true;  // the operator's reset
  if (phase_ != Phase::kReady)
    return refuse(kNoCode, std::string("the stage is ") + name(state()), fx), false;
  return true;
}

void Stage::begin_pass(const DropletPattern& pattern, int pass, double z_mm, double speed_mm_s,
                       std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kPass, fx)) return;
  const double speed = speed_mm_s == 0.0 ? config_.raster_speed_mm_s : speed_mm_s;
  if (!in_range(speed, config_.limits[0].max_speed_mm_s))
    return refuse(kLimit, too_fast('X', speed, config_.limits[0].max_speed_mm_s), fx);
  if (speed / pattern.spec.pitch_x_mm > config_.max_pulse_rate_hz) {
    char text[120];
    std::snprintf(text, sizeof text, "%.1f mm/s over a pitch of %.6f mm is %.1f Hz; the jet follows %.1f Hz",
                  speed, pattern.spec.pitch_x_mm, speed / pattern.spec.pitch_x_mm, config_.max_pulse_rate_hz);
    return refuse(kLimit, text, fx);
  }
  std::vector<RasterRun> runs = plan_raster(pattern, pass, raster_params(config_, speed));
  std::int64_t expected = 0;
  for (const RasterRun& run : runs) {
    for (const double x : {run.start_x_mm, run.end_x_mm})
      if (auto why = limit_broken('X', x, config_.limits[0]))
        return refuse(kLimit, *why + " (row " + std::to_string(run.row) + ")", fx);
    if (auto why = limit_broken('Y', run.y_mm, config_.limits[1]))
      return refuse(kLimit, *why + " (row " + std::to_string(run.row) + ")", fx);
    expected += std::int64_t(run.increments.size());
  }
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, config_.limits[2]))
    return refuse(kLimit, *why, fx);
  op_ = Op::kPass;
  start_mm_ = {kNaN, kNaN, z_mm};
  runs_ = std::move(runs);
  expected_ = expected;
  speed_mm_s_ = speed;
  if (runs_.empty()) return finish({Outcome::kDone, 0, 0, 0, 0, kNoCode, "no droplets in this pass"}, fx);
  start_operation(now_us, fx);
}

void Stage::begin_scan(double x_mm, double y_mm, double z_mm, double pitch_mm, int rows, double speed_mm_s,
                       std::int64_t now_us, Effects& fx) {
  if (!accept(Op::kScan, fx)) return;
  const double speed = speed_mm_s == 0.0 ? config_.move_speed_mm_s : speed_mm_s;
  if (!in_range(speed, config_.limits[1].max_speed_mm_s))
    return refuse(kLimit, too_fast('Y', speed, config_.limits[1].max_speed_mm_s), fx);
  if (rows < 1 || rows > 1'000'000) return refuse(kLimit, "a scan of " + std::to_string(rows) + " rows", fx);
  // Fixed-distance pulses count from the arming position, so the arm is one pitch before the first row and
  // the whole run-up must fit into it. Distances are whole counts, so that neither side rounds while it adds
  // up.
  const double pitch = std::round(pitch_mm * config_.counts_per_mm) / config_.counts_per_mm;
  if (!(pitch > 0.0 && pitch < 100.0))
    return refuse(kLimit, "a scan pitch of " + std::to_string(pitch_mm) + " mm", fx);
  if (run_up_mm({speed, config_.acceleration_mm_s2, 0.0}) > pitch) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "axis Y: scan speed %.4f mm/s needs more run-up than one pitch; limit %.4f mm/s", speed,
                  std::sqrt(2.0 * config_.acceleration_mm_s2 * pitch));
    return refuse(kLimit, text, fx);
  }
  const double end_y_mm = y_mm + (rows - 0.5) * pitch;
  if (auto why = limit_broken('X', x_mm, config_.limits[0])) return refuse(kLimit, *why, fx);
  for (const double y : {y_mm - pitch, end_y_mm})
    if (auto why = limit_broken('Y', y, config_.limits[1])) return refuse(kLimit, *why, fx);
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, config_.limits[2]))
    return refuse(kLimit, *why, fx);
  op_ = Op::kScan;
  runs_.clear();
  expected_ = rows;
  speed_mm_s_ = speed;
  scan_pitch_mm_ = pitch;
  start_mm_ = {x_mm, y_mm - pitch, z_mm};
  start_operation(now_us, fx);
}

void Stage::begin_move(double x_mm, double y_mm, double z_mm, double speed_mm_s, std::int64_t now_us,
                       Effects& fx) {
  if (!accept(Op::kMove, fx)) return;
  const std::array<double, 3> target{x_mm, y_mm, z_mm};
  double speed = speed_mm_s == 0.0 ? config_.move_speed_mm_s : speed_mm_s;
  bool any = false;
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::isnan(target[a])) continue;
    any = true;
    if (auto why = limit_broken(kAxisNames[a], target[a], config_.limits[a])) return refuse(kLimit, *why, fx);
    const double limit = config_.limits[a].max_speed_mm_s;
    if (speed_mm_s == 0.0 && speed > limit) speed = limit;
    if (!in_range(speed, limit)) return refuse(kLimit, too_fast(kAxisNames[a], speed, limit), fx);
  }
  op_ = Op::kMove;
  runs_.clear();
  expected_ = 0;
  speed_mm_s_ = speed;
  start_mm_ = target;
  if (!any) return finish({Outcome::kDone, -1, 0, 0, 0, kNoCode, "no axis to move"}, fx);
  start_operation(now_us, fx);
}

void Stage::begin_home(Effects& fx) {
  if (!accept(Op::kHome, fx)) return;
  op_ = Op::kHome;
  expected_ = 0;
  progress_ = {};
  ending_.clear();
  ending_code_ = kNoCode;
  doom_.reset();
  initialised_ = false;
  restarted_ = was_homed_ = false;
  set_state(DriverState::kActive, "homing", fx);
  phase_ = Phase::kFaultCheck;
  axis_ = 0;
  asked_ = acknowledged_ = false;
}

void Stage::start_operation(std::int64_t now_us, Effects& fx) {
  progress_ = {};
  pulses_.reset();
  restarted_ = false;
  ending_.clear();
  ending_code_ = kNoCode;
  set_state(DriverState::kActive, op_ == Op::kPass ? "raster pass" : op_ == Op::kScan ? "scan" : "move", fx);
  if (initialised_) return go_to_start(now_us);
  phase_ = Phase::kFaultCheck;  // a stop came before the axes were homed
  axis_ = 0;
  asked_ = acknowledged_ = false;
}

}  // namespace firn::drivers
