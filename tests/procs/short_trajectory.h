// short_trajectory() makes a motion of the path printer's arm that its driver accepts.
#pragma once

#include <cstdint>

#include "firn/trajectory_t.hpp"

namespace firn::test {

/// A smooth step of 0.1 rad of the first two joints, a sample every 16 ms.
inline trajectory_t short_trajectory(std::int64_t path, int samples) {
  trajectory_t m{};
  m.path = path;
  m.tick_s = 0.016;
  m.axes = 4;
  m.axis_unit = {"rad", "rad", "mm", "rad"};
  m.samples = samples;
  m.n = 4 * samples;
  for (int k = 0; k < samples; ++k) {
    const double u = double(k) / (samples - 1), s = 0.1 * u * u * (3 - 2 * u);
    for (const double q : {-0.8 + s, 1.5 - s, 60.0, -0.7}) m.position.push_back(q);
  }
  m.duration_s = 0.016 * (samples - 1);
  return m;
}

}  // namespace firn::test
