// certified_bound_mm() computes the lower bound that given multipliers prove, in double precision and without
// the solver's code. Rows of cells' costs (|error|, cell_cost.h) are cut into strips of m. At cut k, for
// every column x, the droplets of the two rows at the cut in columns x - 1, x, x + 1 pay multipliers[(k nx +
// x) 64 + pattern] in the strip above and earn it in the strip below; pattern = 16 p(x - 1) + 4 p(x) + p(x +
// 1), p = 2 * upper row + lower row. Each strip's least cost is found column by column.
// A droplet pays cell_cost.outside for each mm that it adds beside the part, in the strip where its own cell
// counts.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/control/controller.h"
#include "core/control/mpc/layer/cell_cost.h"

namespace firn::control::mpc {

/// @pre multipliers.size() = (strips - 1) nx 64, strips = ny / m rounded up
inline double certified_bound_mm(const Setup& setup, const HeightMap& height, const MaterialMap& inks, int m,
                                 std::span<const float> multipliers, const CellCost& cell_cost = {}) {
  const int nx = height.spec.nx, ny = height.spec.ny, strips = (ny + m - 1) / m, rows = m + 2,
            patterns = 1 << rows;
  const auto part = [&](int i, int j) { return height.spec.contains(i, j) && setup.mask.at(i, j); };
  // Height that a droplet on (i, j) adds to (i + dx, j + dy): Lu (3)-(5).
  const auto adds = [&](int i, int j, int dx, int dy) {
    const deposition::DropletModel& ink =
        setup.model_of(inks.size() ? inks.of(height.spec.index(i, j)) : Material::kA);
    const auto flow = [&](int fx, int fy) {
      const double w = fx != 0 && fy != 0 ? ink.h3_mm : ink.h2_mm;
      if (!height.spec.contains(i + fx, j + fy)) return setup.border == deposition::Border::kLose ? w : 0.0;
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
    // share[(x 3 + dx + 1) m + r][u]: height that pattern u of column x adds to counted row r of column x +
    // dx
    std::vector<std::vector<double>> share(std::size_t(nx * 3 * m),
                                           std::vector<double>(std::size_t(patterns), 0.0));
    std::vector<int> barred(std::size_t(nx), 0);
    std::vector<double> beside(std::size_t(nx) * std::size_t(patterns), 0.0);  // price of a column's pattern
    for (int x = 0; x < nx; ++x)
      for (int b = 0; b < rows; ++b) {
        const int j = s * m - 1 + b;
        barred[std::size_t(x)] |= int(!part(x, j)) << b;
        if (cell_cost.outside > 0.0f && b >= 1 && b <= m && part(x, j)) {
          double mm = 0.0;
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
              if (!part(x + dx, j + dy)) mm += adds(x, j, dx, dy);
          for (int u = 0; u < patterns; ++u)
            if (u >> b & 1) beside[std::size_t(x * patterns + u)] += double(cell_cost.outside) * mm;
        }
        for (int dx = -1; dx <= 1; ++dx)
          for (int r = 0; r < m; ++r) {
            const int dy = s * m + r - j;
            if (!part(x, j) || std::abs(dy) > 1 || !part(x + dx, s * m + r)) continue;
            const double h = adds(x, j, dx, dy);
            for (int u = 0; u < patterns; ++u)
              if (u >> b & 1) share[std::size_t((x * 3 + dx + 1) * m + r)][std::size_t(u)] += h;
          }
      }
    const auto given = [&](int x, int dx, int r, int u) {
      return x < 0 || x >= nx ? 0.0 : share[std::size_t((x * 3 + dx + 1) * m + r)][std::size_t(u)];
    };
    const auto paid = [&](int cut, int x, int shift, int a, int b,
                          int n) {  // two bits from `shift`, upper row the lower bit
      if (cut < 0 || cut >= strips - 1) return 0.0;
      const auto two = [&](int u) { return (u >> shift & 1) * 2 + (u >> (shift + 1) & 1); };
      return double(multipliers[(std::size_t(cut) * std::size_t(nx) + std::size_t(x)) * 64 +
                                std::size_t(two(a) * 16 + two(b) * 4 + two(n))]);
    };
    std::vector<double> best(std::size_t(patterns) * std::size_t(patterns), 1e30), next;  // [before][own]
    for (int u = 0; u < patterns; ++u)
      if ((u & barred[0]) == 0) best[std::size_t(u)] = 0.0;
    for (int x = 0; x < nx; ++x) {
      next.assign(best.size(), 1e30);
      for (int a = 0; a < patterns; ++a)
        for (int b = 0; b < patterns; ++b) {
          if (best[std::size_t(a * patterns + b)] > 1e29) continue;
          for (int n = 0; n < (x + 1 < nx ? patterns : 1); ++n) {
            if (x + 1 < nx && (n & barred[std::size_t(x) + 1])) continue;
            double cost = best[std::size_t(a * patterns + b)] + beside[std::size_t(x * patterns + b)] +
                          paid(s, x, m, a, b, n) - paid(s - 1, x, 0, a, b, n);
            for (int r = 0; r < m; ++r)
              if (part(x, s * m + r))
                cost += cost_of(cell_cost, height.at(x, s * m + r) - setup.target.at(x, s * m + r) +
                                               given(x - 1, 1, r, a) + given(x, 0, r, b) +
                                               given(x + 1, -1, r, n));
            next[std::size_t(b * patterns + n)] = std::min(next[std::size_t(b * patterns + n)], cost);
          }
        }
      best.swap(next);
    }
    bound += *std::min_element(best.begin(), best.end());
  }
  return bound;
}

}  // namespace firn::control::mpc
