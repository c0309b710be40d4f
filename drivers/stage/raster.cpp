#include "drivers/stage/raster.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/grid/firing_order.h"

namespace firn::drivers {

double run_up_mm(const RasterParams& p) {
  return p.speed_mm_s * p.speed_mm_s / (2.0 * p.acceleration_mm_s2) + p.margin_mm;
}

double move_time_s(double distance_mm, double speed_mm_s, double acceleration_mm_s2) {
  const double d = std::abs(distance_mm);
  if (d * acceleration_mm_s2 >= speed_mm_s * speed_mm_s)
    return d / speed_mm_s + speed_mm_s / acceleration_mm_s2;
  return 2.0 * std::sqrt(d / acceleration_mm_s2);
}

std::vector<RasterRun> plan_raster(const DropletPattern& pattern, int pass, const RasterParams& params,
                                   const Placement& placement) {
  const GridSpec& grid = pattern.spec;
  const Aim aim{.lead_mm = params.lead_mm};
  std::vector<RasterRun> runs;
  std::size_t first_drop = 0;
  for (const FiringRun& row : firing_runs(pattern, pass, placement)) {
    const double direction = row.towards_plus_x ? 1.0 : -1.0;
    for (std::size_t from = 0; from < row.cells.size(); from += std::size_t(params.array_limit)) {
      const std::size_t to = std::min(row.cells.size(), from + std::size_t(params.array_limit));
      const auto place = [&](std::size_t k) {
        return stage_place(grid, int(row.cells[k] % std::uint32_t(grid.nx)), row.row,
                           placement.of(row.cells[k]), aim, row.towards_plus_x);
      };
      RasterRun run;
      run.row = row.row;
      run.speed_mm_s = params.speed_mm_s;
      for (std::size_t k = from + 1; k < to && !placement.map.cells.empty() && params.max_rate_hz > 0.0; ++k)
        run.speed_mm_s = std::min(
            run.speed_mm_s, std::abs(place(k).x_mm - place(k - 1).x_mm) * kRateShare * params.max_rate_hz);
      RasterParams own = params;
      own.speed_mm_s = run.speed_mm_s;
      const double run_up = run_up_mm(own);
      run.y_mm = place(from).y_mm;
      run.start_x_mm = place(from).x_mm - direction * run_up;
      run.end_x_mm = place(to - 1).x_mm + direction * run_up;
      run.first_drop = first_drop;
      first_drop += to - from;
      std::int64_t at = std::llround(run.start_x_mm * params.counts_per_mm);
      for (std::size_t k = from; k < to; ++k) {
        const std::int64_t pulse = std::llround(place(k).x_mm * params.counts_per_mm);
        run.increments.push_back(std::llabs(pulse - at));
        at = pulse;
      }
      runs.push_back(std::move(run));
    }
  }
  return runs;
}

double raster_time_s(const std::vector<RasterRun>& runs, const RasterParams& params) {
  double time_s = 0.0;
  for (const RasterRun& run : runs)
    time_s += move_time_s(run.end_x_mm - run.start_x_mm, run.speed_mm_s, params.acceleration_mm_s2) + kTurn_s;
  return time_s;
}

double quicker_apart_mm(const DropletPattern& fires, const RasterParams& params, Placement placement) {
  if (placement.map.cells.empty() || params.max_rate_hz <= 0.0) return 0.0;
  placement.apart_mm = 0.0;
  const double slower_s = raster_time_s(plan_raster(fires, 0, params, placement), params);
  placement.apart_mm = params.speed_mm_s / (kRateShare * params.max_rate_hz);
  const double twice_s = raster_time_s(plan_raster(fires, 0, params, placement), params);
  return twice_s < slower_s ? placement.apart_mm : 0.0;
}

PulseRange pulses_by_place(const RasterRun& run, double x_mm, double stop_mm, double slack_mm,
                           double counts_per_mm) {
  const double travelled_mm = run.end_x_mm < run.start_x_mm ? run.start_x_mm - x_mm : x_mm - run.start_x_mm;
  PulseRange range;
  double at_mm = 0.0;
  for (const std::int64_t increment : run.increments) {
    at_mm += double(increment) / counts_per_mm;
    range.least += at_mm <= travelled_mm - stop_mm - slack_mm;
    range.most += at_mm <= travelled_mm + slack_mm;
  }
  return range;
}

std::optional<std::string> limit_broken(char axis_name, double value_mm, const AxisLimits& limits) {
  if (value_mm >= limits.min_mm && value_mm <= limits.max_mm) return std::nullopt;  // false for NaN
  char text[120];
  std::snprintf(text, sizeof text, "axis %c: %.4f mm is outside [%.4f, %.4f] mm", axis_name, value_mm,
                limits.min_mm, limits.max_mm);
  return text;
}

}  // namespace firn::drivers
