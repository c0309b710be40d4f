#include "drivers/stage/raster.h"

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

std::vector<RasterRun> plan_raster(const DropletPattern& pattern, int pass, const RasterParams& params) {
  const GridSpec& grid = pattern.spec;
  const std::vector<std::uint32_t> order = firing_order(pattern, pass);
  const double run_up = run_up_mm(params);
  std::vector<RasterRun> runs;
  std::size_t n = 0;
  while (n < order.size()) {
    const int j = int(order[n] / std::uint32_t(grid.nx));
    std::size_t end = n + 1;
    while (end < order.size() && int(order[end] / std::uint32_t(grid.nx)) == j &&
           end - n < std::size_t(params.array_limit))
      ++end;
    const double direction = towards_plus_x(j) ? 1.0 : -1.0;
    const auto x_mm = [&](std::size_t k) {
      return grid.x_mm(int(order[k] % std::uint32_t(grid.nx))) - direction * params.lead_mm;
    };
    RasterRun run;
    run.row = j;
    run.y_mm = grid.y_mm(j);
    run.start_x_mm = x_mm(n) - direction * run_up;
    run.end_x_mm = x_mm(end - 1) + direction * run_up;
    run.first_drop = n;
    std::int64_t at = std::llround(run.start_x_mm * params.counts_per_mm);
    for (std::size_t k = n; k < end; ++k) {
      const std::int64_t pulse = std::llround(x_mm(k) * params.counts_per_mm);
      run.increments.push_back(std::llabs(pulse - at));
      at = pulse;
    }
    runs.push_back(std::move(run));
    n = end;
  }
  return runs;
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
