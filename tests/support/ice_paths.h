// Computes paths for the ice plant independently of slicer and planner: polylines at one speed as joint
// points and pulse lists, with the arm's inverse kinematics and the pulse rule written out again.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "plant/ice/nature.h"

namespace firn::plant::ice_paths {

struct At {
  double x_mm, y_mm;
};

/// Part frame to joints of the arm that the world believes in: tool tip at (x, y), nozzle height z, yaw 0.
inline Joints joints_of(const IceArmParams& arm, const IceTool& tool, const At& at, double z_mm) {
  const double x = at.x_mm - tool.x_mm + arm.origin_mm[0], y = at.y_mm - tool.y_mm + arm.origin_mm[1];
  const double c = (x * x + y * y - arm.link_1_mm * arm.link_1_mm - arm.link_2_mm * arm.link_2_mm) /
                   (2.0 * arm.link_1_mm * arm.link_2_mm);
  const double q2 = std::acos(c), q1 = std::atan2(y, x) - std::atan2(arm.link_2_mm * std::sin(q2),
                                                                     arm.link_1_mm + arm.link_2_mm * c);
  return {q1, q2, z_mm - tool.z_mm + arm.origin_mm[2], -q1 - q2};
}

struct Run {
  std::vector<Joints> points;
  std::vector<std::uint16_t> ticks;
  double length_mm = 0.0, duration_s = 0.0;
};

/// Along `line` from rest to rest with 500 mm/s^2; `width_mm` x 0.24 mm of volume per length at
/// `mm3_per_pulse`.
/// @param early_s how much sooner than the reference the pulses come
inline Run along(const IceArmParams& arm, const IceTool& tool, const std::vector<At>& line, double z_mm,
                 double speed_mm_s, double width_mm, const std::function<double(double hz)>& mm3_per_pulse,
                 double late_s) {
  Run run;
  std::vector<double> s{0.0};
  for (std::size_t n = 1; n < line.size(); ++n)
    s.push_back(s.back() + std::hypot(line[n].x_mm - line[n - 1].x_mm, line[n].y_mm - line[n - 1].y_mm));
  run.length_mm = s.back();
  constexpr double kAccel = 500.0, kTick_s = 0.016;
  const double top = std::min(speed_mm_s, std::sqrt(kAccel * run.length_mm));
  const double ramp_s = top / kAccel, cruise_s = (run.length_mm - top * ramp_s) / top;
  const int ticks = int(std::ceil((2.0 * ramp_s + cruise_s) / kTick_s));
  run.duration_s = ticks * kTick_s;
  const double total_s = 2.0 * ramp_s + cruise_s;
  const auto travelled = [&](double t) {
    t = std::clamp(t, 0.0, total_s);
    if (t < ramp_s) return 0.5 * kAccel * t * t;
    if (t < ramp_s + cruise_s) return top * (t - 0.5 * ramp_s);
    const double left = total_s - t;
    return run.length_mm - 0.5 * kAccel * left * left;
  };
  std::size_t k = 0;
  for (int n = 0; n <= ticks; ++n) {
    const double at = std::min(travelled(n * kTick_s), run.length_mm);
    while (k + 2 < s.size() && s[k + 1] < at) ++k;
    const double f = s[k + 1] > s[k] ? (at - s[k]) / (s[k + 1] - s[k]) : 0.0;
    run.points.push_back(joints_of(arm, tool,
                                   {line[k].x_mm + f * (line[k + 1].x_mm - line[k].x_mm),
                                    line[k].y_mm + f * (line[k + 1].y_mm - line[k].y_mm)},
                                   z_mm));
  }
  double pulses = 0.0;
  for (double t = 0.0; t < total_s; t += 0.002) {
    const double speed = (travelled(t + 0.001) - travelled(t - 0.001)) / 0.002,
                 flow = speed * width_mm * 0.24;
    double hz = flow / 0.25;
    for (int n = 0; n < 20; ++n) hz = hz > 0.0 ? flow / mm3_per_pulse(hz) : 0.0;
    const double before = pulses;
    pulses += hz * 0.002;
    if (std::floor(pulses + 0.5) > std::floor(before + 0.5))
      run.ticks.push_back(std::uint16_t(std::lround((t + late_s) / 0.002)));
  }
  return run;
}

inline std::vector<At> ring(double radius_mm, double from_deg = 0.0) {
  const int n = std::max(16, int(2.0 * std::numbers::pi * radius_mm / 0.5));
  std::vector<At> line;
  for (int k = 0; k <= n; ++k) {
    const double a = 2.0 * std::numbers::pi * k / n + from_deg * std::numbers::pi / 180.0;
    line.push_back({radius_mm * std::cos(a), radius_mm * std::sin(a)});
  }
  return line;
}

/// Computes the delay that a planner with calibrated delays would add: servo lag and start delay less the
/// valve's own.
inline double calibrated_late_s(const IceWorldConfig& c, int valve) {
  return 2.0 * c.arm.servo_damping / (2.0 * std::numbers::pi * c.arm.servo_hz) + c.arm.start_delay_s +
         0.5 * c.arm.start_jitter_s - c.line[std::size_t(valve)].open_delay_s;
}

/// Runs one path in nature: signal at t_us, motion after the arm's start delay. Returns when the list is
/// through.
inline std::int64_t print(IceNature& nature, const IceWorldConfig& c, Run run, int valve, std::int64_t t_us) {
  nature.catch_up(t_us);
  nature.arm().place(run.points.front());
  const double t_s = double(t_us) * 1e-6;
  nature.arm().follow(run.points, 0.016, t_s + c.arm.start_delay_s + 0.5 * c.arm.start_jitter_s);
  Firing list;
  list.ticks = run.ticks;
  nature.trigger_valve(valve, t_s, std::move(list));
  const std::int64_t end_us = t_us + std::int64_t((run.duration_s + 0.2) * 1e6);
  nature.catch_up(end_us);
  nature.close_valve(valve);
  return end_us;
}

}  // namespace firn::plant::ice_paths
