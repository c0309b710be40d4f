// Checks a lower bound from its multipliers alone, in double precision and with nothing of the solver: the reader's copy of
// the proof. Rows of |error| are cut into strips of m; droplets of the two rows at cut k pay multipliers[2k], [2k + 1] in
// the strip above the cut and earn them below; each strip's least cost is found column by column.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"

namespace firn::test {

inline double certified_bound_mm(const HeightMap& height, const HeightMap& target, const Mask& mask,
                                 const deposition::DropletModel& ink, bool lose, int m, const std::vector<float>& multipliers) {
  const int nx = height.spec.nx, ny = height.spec.ny, strips = (ny + m - 1) / m, bits = m + 2, patterns = 1 << bits;
  const auto part = [&](int i, int j) { return height.spec.contains(i, j) && mask.at(i, j); };
  // What a droplet on (i, j) adds to (i + dx, j + dy): Lu (3)-(5).
  const auto adds = [&](int i, int j, int dx, int dy) {
    const auto flow = [&](int fx, int fy) {
      const double w = fx != 0 && fy != 0 ? ink.h3_mm : ink.h2_mm;
      if (!height.spec.contains(i + fx, j + fy)) return lose ? w : 0.0;
      return w * deposition::sat(ink.h1_mm + w, height.at(i, j) - height.at(i + fx, j + fy));
    };
    if (dx != 0 || dy != 0) return flow(dx, dy);
    double own = ink.h1_mm + 4.0 * ink.h2_mm + 4.0 * ink.h3_mm;
    for (int fy = -1; fy <= 1; ++fy)
      for (int fx = -1; fx <= 1; ++fx)
        if (fx != 0 || fy != 0) own -= flow(fx, fy);
    return own;
  };
  double bound = 0.0;
  for (int s = 0; s < strips; ++s) {
    const auto row_of = [&](int bit) { return s * m - 1 + bit; };
    // share[x][dx + 1][r][u]: what pattern u of column x adds to counted row r of column x + dx
    const std::vector<double> zeros(std::size_t(patterns), 0.0);
    std::vector<std::vector<double>> share(std::size_t(nx * 3 * m), zeros), price(std::size_t(nx), zeros);
    for (int x = 0; x < nx; ++x)
      for (int u = 0; u < patterns; ++u)
        for (int b = 0; b < bits; ++b) {
          if (!(u >> b & 1)) continue;
          const int j = row_of(b);
          if (!part(x, j)) price[std::size_t(x)][std::size_t(u)] = 1e30;
          const auto multiplier = [&](int k, int side) { return double(multipliers[std::size_t((2 * k + side) * nx + x)]); };
          if (s > 0 && b < 2) price[std::size_t(x)][std::size_t(u)] -= multiplier(s - 1, b);
          if (s + 1 < strips && b >= m) price[std::size_t(x)][std::size_t(u)] += multiplier(s, b - m);
          if (!height.spec.contains(x, j)) continue;
          for (int dx = -1; dx <= 1; ++dx)
            for (int r = 0; r < m; ++r)
              if (const int dy = s * m + r - j; std::abs(dy) <= 1 && part(x + dx, s * m + r))
                share[std::size_t((x * 3 + dx + 1) * m + r)][std::size_t(u)] += adds(x, j, dx, dy);
        }
    const auto given = [&](int x, int dx, int r, int u) {
      return x < 0 || x >= nx ? 0.0 : share[std::size_t((x * 3 + dx + 1) * m + r)][std::size_t(u)];
    };
    std::vector<double> best(std::size_t(patterns) * std::size_t(patterns), 1e30), next;
    for (int u = 0; u < patterns; ++u) best[std::size_t(u)] = price[0][std::size_t(u)];  // [before][own]
    for (int x = 0; x < nx; ++x) {
      next.assign(best.size(), 1e30);
      for (int a = 0; a < patterns; ++a)
        for (int b = 0; b < patterns; ++b) {
          if (best[std::size_t(a * patterns + b)] > 1e29) continue;
          for (int n = 0; n < (x + 1 < nx ? patterns : 1); ++n) {
            double cost = best[std::size_t(a * patterns + b)] + (x + 1 < nx ? price[std::size_t(x) + 1][std::size_t(n)] : 0.0);
            for (int r = 0; r < m; ++r)
              if (part(x, s * m + r))
                cost += std::abs(height.at(x, s * m + r) - target.at(x, s * m + r) + given(x - 1, 1, r, a) + given(x, 0, r, b) + given(x + 1, -1, r, n));
            next[std::size_t(b * patterns + n)] = std::min(next[std::size_t(b * patterns + n)], cost);
          }
        }
      best.swap(next);
    }
    bound += *std::min_element(best.begin(), best.end());
  }
  return bound;
}

}  // namespace firn::test
