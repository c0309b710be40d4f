// Draws surfaces and layers of droplets at random, and compares surfaces, for tests of deposition models.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/grid/grid.h"
#include "core/grid/random.h"

namespace firn::test {

/// Heights in [0, range_mm).
inline HeightMap rough(const GridSpec& g, RandomStream& random, double range_mm) {
  HeightMap h(g);
  for (double& v : h.cells) v = random.uniform(0.0, range_mm);
  return h;
}

/// Counts in [0, up_to].
inline DropletPattern some_drops(const GridSpec& g, RandomStream& random, std::uint32_t up_to) {
  DropletPattern u(g);
  for (auto& v : u.cells) v = std::uint8_t(random.below(up_to + 1));
  return u;
}

inline double sum(const HeightMap& h) {
  double s = 0.0;
  for (double v : h.cells) s += v;
  return s;
}

/// Largest difference of two surfaces.
inline double worst(const HeightMap& a, const HeightMap& b) {
  double w = 0.0;
  for (std::size_t c = 0; c < a.size(); ++c) w = std::max(w, std::abs(a.cells[c] - b.cells[c]));
  return w;
}

}  // namespace firn::test
