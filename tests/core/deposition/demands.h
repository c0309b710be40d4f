// Holds demands and curves for the tests of valve pulses.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/deposition/pulses.h"
#include "core/grid/random.h"

namespace firn::deposition::test {

constexpr double kStep = 0.016;                                         // the planner's tick
constexpr double kBoundary_mm = 1.5, kFill_mm = 3.0, kLayer_mm = 0.25;  // Barnett 2012, 3.8 and 4.1.5
constexpr double kFeedForward = 4.0;                                    // c_ff [Hz / (mm^3/s)], 5.7

/// Speeds at the planner's tick: from rest through random targets up to `top` and back to rest, at most
/// `acceleration`.
inline std::vector<double> random_speeds(RandomStream& random, double length_mm, double top_mm_s,
                                         double acceleration_mm_s2 = 500.0) {
  std::vector<double> c{0.0};
  const double change = acceleration_mm_s2 * kStep;
  double done = 0.0, target = 0.0;
  while (done < length_mm) {
    if (random.below(12) == 0 || c.size() == 1) target = random.uniform(2.0, top_mm_s);
    c.push_back(c.back() + std::clamp(target - c.back(), -change, change));
    done += 0.5 * kStep * (c[c.size() - 2] + c.back());
  }
  while (c.back() > 0.0) c.push_back(std::max(0.0, c.back() - change));
  return c;
}

inline FlowDemand demand_of(std::vector<double> speeds, double width_mm) {
  FlowDemand d{kStep, std::vector<double>(speeds.size()), std::move(speeds), {}};
  nominal_flow(width_mm, kLayer_mm, d.speed_mm_s, d.flow_mm3_s);
  return d;
}

/// Some 20 calibrated rows that ascend with changing slope, as in Fig. 6-1; about c_ff in the mean.
inline FlowCurve bent_curve(RandomStream& random, int rows = 20) {
  std::vector<FlowCurve::Row> table;
  double flow = 0.0;
  for (int n = 1; n <= rows; ++n) {
    flow += 500.0 / rows / kFeedForward * random.uniform(0.7, 1.3);
    table.push_back({500.0 * n / rows, flow});
  }
  return FlowCurve(table);
}

/// Smooth control actions within +-limit along a path of n instants.
inline std::vector<double> random_action(RandomStream& random, std::size_t n, double limit) {
  std::vector<double> u(n);
  double value = random.uniform(-limit, limit), target = value;
  for (double& v : u) {
    if (random.below(30) == 0) target = random.uniform(-limit, limit);
    v = value += 0.08 * (target - value);
  }
  return u;
}

/// Eq. (6.6), errata: ceil(max - 0.5) pulses, none for max <= 0.5.
inline std::int64_t pulse_count(double max_pulses_needed) {
  return std::max<std::int64_t>(0, std::int64_t(std::ceil(max_pulses_needed - 0.5)));
}

/// Largest relative error that the volume of any window of the length can have, from the counter's own bound
/// at its two ends: half a drop and the volume wanted within half a tick each, over the window's volume.
/// Windows that start or end at an instant are examined. 0 when the path is shorter; +inf when a window wants
/// no volume.
inline double window_error_bound(const FlowDemand& d, const FlowCurve& curve, double tick_s,
                                 double window_mm) {
  const DemandIntegral path(d);
  const double total_mm = path.total_length_mm(), end_s = d.duration_s();
  if (total_mm < window_mm) return 0.0;
  // error bound of the counter at an instant, the larger of the two around it
  const auto off = [&](double time_s) {
    const std::size_t i = std::min(std::size_t(time_s / d.step_s), d.flow_mm3_s.size() - 2);
    double most = 0.0;
    for (const double flow : {d.flow_mm3_s[i], d.flow_mm3_s[i + 1]})
      most = std::max(most, curve.drop_mm3(flow) + flow * tick_s);
    return 0.5 * most;
  };
  double worst = 0.0;
  const auto window = [&](double from_s, double to_s) {
    const double wanted = path.volume_mm3(to_s) - path.volume_mm3(from_s);
    worst = std::max(
        worst, wanted > 0.0 ? (off(from_s) + off(to_s)) / wanted : std::numeric_limits<double>::infinity());
  };
  for (std::size_t i = 0; i < d.flow_mm3_s.size(); ++i) {  // windows that start and that end at an instant
    const double at_s = d.step_s * double(i), at_mm = path.length_mm(at_s);
    if (at_mm + window_mm <= total_mm) window(at_s, path.time_at_length_s(at_mm + window_mm));
    if (at_mm >= window_mm) window(path.time_at_length_s(at_mm - window_mm), std::min(at_s, end_s));
  }
  return worst;
}

}  // namespace firn::deposition::test
