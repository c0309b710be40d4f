#include "core/control/surface/window_mean.h"

#include <algorithm>
#include <cmath>

namespace firn::control {

HeightMap window_mean(const HeightMap& v, int half_x, int half_y) {
  const GridSpec& g = v.spec;
  HeightMap sum(g, 0.0), count(g, 0.0), out(g, kNotMeasured);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      for (int x = std::max(0, i - half_x); x <= std::min(g.nx - 1, i + half_x); ++x)
        if (std::isfinite(v.at(x, j))) {
          sum.at(i, j) += v.at(x, j);
          count.at(i, j) += 1.0;
        }
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (!std::isfinite(v.at(i, j))) continue;
      double total = 0.0, n = 0.0;
      for (int y = std::max(0, j - half_y); y <= std::min(g.ny - 1, j + half_y); ++y) {
        total += sum.at(i, y);
        n += count.at(i, y);
      }
      out.at(i, j) = total / n;
    }
  return out;
}

}  // namespace firn::control
