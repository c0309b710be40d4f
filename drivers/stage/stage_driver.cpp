#include "drivers/stage/stage_driver.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace firn::drivers {
namespace {

RasterParams raster_params(const StageOptions& c, double speed_mm_s, double lead_mm) {
  return {speed_mm_s,           c.acceleration_mm_s2, lead_mm, c.dialect.margin_mm, c.counts_per_mm,
          c.table.increments(), c.max_pulse_rate_hz};
}

std::string too_fast(char axis, double speed_mm_s, double limit_mm_s) {
  char text[100];
  std::snprintf(text, sizeof text, "axis %c: speed %.4f mm/s is outside (0, %.4f] mm/s", axis, speed_mm_s,
                limit_mm_s);
  return text;
}

bool in_range(double speed_mm_s, double limit_mm_s) { return speed_mm_s > 0.0 && speed_mm_s <= limit_mm_s; }

}  // namespace

StageDriver::StageDriver(const Dialect& dialect, StageOptions config)
    : Driver(dialect), config_(std::move(config)) {
  check_options("stage", kStageConfig, config_);
  limits_ = {{{config_.x_min_mm, config_.x_max_mm, config_.max_speed_mm_s},
              {config_.y_min_mm, config_.y_max_mm, config_.max_speed_mm_s},
              {config_.z_min_mm, config_.z_max_mm, config_.max_speed_mm_s}}};
}

void StageDriver::refuse(std::int32_t code, std::string text, Effects& fx) {
  Result r;
  r.outcome = Outcome::kRefused;
  r.code = code;
  r.text = std::move(text);
  fx.events.emplace_back(std::move(r));
}

std::optional<StageDriver::Refusal> StageDriver::plan_pass(const DropletPattern& pattern, int pass,
                                                           double z_mm, double speed_mm_s, double lead_mm,
                                                           const Placement& placement, PassPlan& plan) const {
  const double speed = speed_mm_s == 0.0 ? config_.raster_speed_mm_s : speed_mm_s;
  if (!in_range(speed, limits_[0].max_speed_mm_s))
    return Refusal{kLimit, too_fast('X', speed, limits_[0].max_speed_mm_s)};
  if (speed / pattern.spec.pitch_x_mm > config_.max_pulse_rate_hz) {
    char text[120];
    std::snprintf(text, sizeof text, "%.1f mm/s over a pitch of %.6f mm is %.1f Hz; the jet follows %.1f Hz",
                  speed, pattern.spec.pitch_x_mm, speed / pattern.spec.pitch_x_mm, config_.max_pulse_rate_hz);
    return Refusal{kLimit, text};
  }
  try {
    check(placement, pattern.spec);
  } catch (const std::invalid_argument& why) {
    return Refusal{kNoCode, why.what()};
  }
  std::vector<RasterRun> runs = plan_raster(pattern, pass, raster_params(config_, speed, lead_mm), placement);
  std::int64_t expected = 0;
  for (const RasterRun& run : runs) {
    for (const double x : {run.start_x_mm, run.end_x_mm})
      if (auto why = limit_broken('X', x, limits_[0]))
        return Refusal{kLimit, *why + " (row " + std::to_string(run.row) + ")"};
    if (auto why = limit_broken('Y', run.y_mm, limits_[1]))
      return Refusal{kLimit, *why + " (row " + std::to_string(run.row) + ")"};
    expected += std::int64_t(run.increments.size());
  }
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, limits_[2]))
    return Refusal{kLimit, *why};
  plan = {std::move(runs), expected, speed};
  return std::nullopt;
}

std::optional<StageDriver::Refusal> StageDriver::plan_scan(double x_mm, double y_mm, double z_mm,
                                                           double pitch_mm, int rows, double speed_mm_s,
                                                           ScanPlan& plan) const {
  const double speed = speed_mm_s == 0.0 ? config_.move_speed_mm_s : speed_mm_s;
  if (!in_range(speed, limits_[1].max_speed_mm_s))
    return Refusal{kLimit, too_fast('Y', speed, limits_[1].max_speed_mm_s)};
  if (rows < 1 || rows > 1'000'000) return Refusal{kLimit, "a scan of " + std::to_string(rows) + " rows"};
  // Fixed-distance pulses count from the arming position, so the arm is one pitch before the first row and
  // the whole run-up must fit into it. Distances are whole counts, so that neither side rounds while it adds
  // up.
  const double pitch = std::round(pitch_mm * config_.counts_per_mm) / config_.counts_per_mm;
  if (!(pitch > 0.0 && pitch < 100.0))
    return Refusal{kLimit, "a scan pitch of " + std::to_string(pitch_mm) + " mm"};
  if (run_up_mm({.speed_mm_s = speed, .acceleration_mm_s2 = config_.acceleration_mm_s2, .margin_mm = 0.0}) >
      pitch) {
    char text[120];
    std::snprintf(text, sizeof text,
                  "axis Y: scan speed %.4f mm/s needs more run-up than one pitch; limit %.4f mm/s", speed,
                  std::sqrt(2.0 * config_.acceleration_mm_s2 * pitch));
    return Refusal{kLimit, text};
  }
  const double end_y_mm = y_mm + (rows - 0.5) * pitch;
  if (auto why = limit_broken('X', x_mm, limits_[0])) return Refusal{kLimit, *why};
  for (const double y : {y_mm - pitch, end_y_mm})
    if (auto why = limit_broken('Y', y, limits_[1])) return Refusal{kLimit, *why};
  if (auto why = std::isnan(z_mm) ? std::nullopt : limit_broken('Z', z_mm, limits_[2]))
    return Refusal{kLimit, *why};
  plan = {pitch, speed};
  return std::nullopt;
}

std::optional<StageDriver::Refusal> StageDriver::plan_move(const std::array<double, 3>& target_mm,
                                                           double& speed_mm_s) const {
  const bool chosen = speed_mm_s != 0.0;
  if (!chosen) speed_mm_s = config_.move_speed_mm_s;
  for (std::size_t a = 0; a < 3; ++a) {
    if (std::isnan(target_mm[a])) continue;
    if (auto why = limit_broken(kAxisNames[a], target_mm[a], limits_[a])) return Refusal{kLimit, *why};
    const double limit = limits_[a].max_speed_mm_s;
    if (!chosen && speed_mm_s > limit) speed_mm_s = limit;
    if (!in_range(speed_mm_s, limit)) return Refusal{kLimit, too_fast(kAxisNames[a], speed_mm_s, limit)};
  }
  return std::nullopt;
}

}  // namespace firn::drivers
