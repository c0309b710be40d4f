// Computes readings of a surface along a sent trajectory, for the tests of the ice lab.
#pragma once

#include <algorithm>
#include <cmath>

#include "firn/laser_samples_t.hpp"
#include "firn/trajectory_t.hpp"
#include "tests/support/ice_print.h"

namespace firn::test {

/// Readings of a surface along a sent trajectory, as a laser with the configured latency takes them.
inline laser_samples_t readings(const trajectory_t& t, double latency_s, double (*height)(double, double),
                                int index, int count, std::int64_t scan) {
  const Experiment e = ice_experiment();
  const Machine machine = cobra();
  const auto arm = make_arm(machine);
  laser_samples_t s{};
  s.layer = t.layer;
  s.scan_id = scan;
  s.path = t.path;
  s.index = index;
  s.count = count;
  s.material = t.material;
  s.period_s = 0.01;
  for (double at = latency_s; at < t.duration_s + 0.05; at += 0.01) {
    const double ticks = std::min(at / t.tick_s, double(t.samples - 1));
    const std::size_t i = std::min(std::size_t(ticks), std::size_t(t.samples - 2));
    motion::JointVector q{};
    for (std::size_t a = 0; a < 4; ++a)
      q[a] =
          t.position[4 * i + a] + (ticks - double(i)) * (t.position[4 * i + 4 + a] - t.position[4 * i + a]);
    const motion::TaskVector flange = arm->forward(q);
    const double c = std::cos(flange[3]), n = std::sin(flange[3]);
    const double x = flange[0] + c * machine.laser.x_mm - n * machine.laser.y_mm - e.ice.origin_x_mm;
    const double y = flange[1] + n * machine.laser.x_mm + c * machine.laser.y_mm - e.ice.origin_y_mm;
    s.distance_mm.push_back(float(height(x, y) - (flange[2] + machine.laser.z_mm - e.ice.origin_z_mm)));
  }
  s.n = std::int32_t(s.distance_mm.size());
  return s;
}

}  // namespace firn::test
