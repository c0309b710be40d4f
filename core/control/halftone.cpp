#include "core/control/halftone.h"

#include <algorithm>

#include "core/grid/firing_order.h"

namespace firn::control {
namespace {

std::uint8_t nearest(double wanted, int max_drops) {
  return std::uint8_t(std::clamp(wanted + 0.5, 0.0, double(max_drops) + 0.5));
}

// The quantisation error of a cell. A saturated cell passes on at most half a droplet, so that its neighbours
// do not get too much.
double rest(double wanted, std::uint8_t placed) { return std::clamp(wanted - placed, -0.5, 0.5); }

void diffuse(Grid<double>& wish, const Mask& mask, int max_drops, DropletPattern& drops) {
  const GridSpec& g = wish.spec;
  for (int j = 0; j < g.ny; ++j) {
    const int ahead = towards_plus_x(j) ? 1 : -1;
    for (int n = 0; n < g.nx; ++n) {
      const int i = ahead > 0 ? n : g.nx - 1 - n;
      if (!mask.at(i, j)) continue;
      drops.at(i, j) = nearest(wish.at(i, j), max_drops);
      const double left = rest(wish.at(i, j), drops.at(i, j));
      struct {
        int di, dj;
        double weight;
      } const to[] = {{ahead, 0, 7.0}, {-ahead, 1, 3.0}, {0, 1, 5.0}, {ahead, 1, 1.0}};
      double sum = 0.0;
      for (const auto& t : to)
        if (g.contains(i + t.di, j + t.dj) && mask.at(i + t.di, j + t.dj)) sum += t.weight;
      if (sum == 0.0) continue;
      for (const auto& t : to)
        if (g.contains(i + t.di, j + t.dj) && mask.at(i + t.di, j + t.dj))
          wish.at(i + t.di, j + t.dj) += left * (t.weight / sum);
    }
  }
}

}  // namespace

DropletPattern halftone(const Grid<double>& wanted, const Mask& mask, int max_drops, Rounding rounding,
                        Grid<double>& carry) {
  DropletPattern drops(wanted.spec);
  if (rounding == Rounding::kDiffusion) {
    Grid<double> wish = wanted;
    diffuse(wish, mask, max_drops, drops);
    return drops;
  }
  for (std::size_t c = 0; c < wanted.size(); ++c) {
    if (!mask.cells[c]) continue;
    const double wish = wanted.cells[c] + (rounding == Rounding::kCarry ? carry.cells[c] : 0.0);
    drops.cells[c] = nearest(wish, max_drops);
    if (rounding == Rounding::kCarry) carry.cells[c] = rest(wish, drops.cells[c]);
  }
  return drops;
}

}  // namespace firn::control
