#include "estimators/droplet/place_prints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace firn::droplet {
namespace {

using deposition::OffsetKernel;
constexpr int kReach = OffsetKernel::kRadius;
constexpr int kAlone = 2 * kReach;  // cells: two droplets so far apart share no cell of their kernels

bool alone(const DropletPattern& fired, const DropletPattern& earlier, int i, int j) {
  for (int y = std::max(0, j - kAlone); y <= std::min(fired.spec.ny - 1, j + kAlone); ++y)
    for (int x = std::max(0, i - kAlone); x <= std::min(fired.spec.nx - 1, i + kAlone); ++x)
      if (earlier.at(x, y) || (fired.at(x, y) && !(x == i && y == j))) return false;
  return fired.at(i, j) == 1;
}

bool seen(const PrintedLayer& l, int i, int j) {
  for (int y = j - kReach; y <= j + kReach; ++y)
    for (int x = i - kReach; x <= i + kReach; ++x)
      if (!l.fired.spec.contains(x, y) || l.use[l.fired.spec.index(x, y)] != Use::kLearn) return false;
  return true;
}

}  // namespace

bool PlacePrints::complete() const {
  return !places.empty() && std::ranges::all_of(places, [](const PlaceRise& p) { return p.own.n >= 2; });
}

OffsetKernel nearest_kernel(const Rise& rise, double drop_height_mm) {
  OffsetKernel k;
  for (int y = 0; y < OffsetKernel::kSide; ++y)
    for (int x = 0; x < OffsetKernel::kSide; ++x)
      k.height_mm[OffsetKernel::index(x - kReach, y - kReach)] = rise.mean_mm[y][x];
  std::array<double, OffsetKernel::kCells> sorted = k.height_mm;
  std::ranges::sort(sorted, std::greater<>());
  // The level below which heights vanish, such that the others less the level have the wanted sum.
  double sum = 0.0, level = 0.0;
  for (int n = 0; n < OffsetKernel::kCells; ++n) {
    sum += sorted[std::size_t(n)];
    const double at = (sum - drop_height_mm) / double(n + 1);
    if (sorted[std::size_t(n)] > at) level = at;
  }
  for (double& h : k.height_mm) h = std::max(0.0, h - level);
  return k;
}

PlacePrints find_place_prints(const std::vector<PrintedLayer>& layers, const std::vector<OffsetMap>& offsets,
                              const OffsetTable& table) {
  PlacePrints p;
  p.places.resize(std::size_t(table.size()));
  if (layers.empty()) return p;
  const GridSpec& g = layers.front().fired.spec;
  DropletPattern earlier(g);
  std::vector<std::vector<double>> own(p.places.size());
  std::vector<double> all;
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const PrintedLayer& l = layers[n];
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        if (l.fired.at(i, j) != 1 || !alone(l.fired, earlier, i, j) || !seen(l, i, j)) continue;
        const auto place = std::size_t(offsets[n].of(g.index(i, j)));
        if (place >= p.places.size()) continue;
        Rise& mean = p.places[place].rise;
        ++mean.n;
        double sum = 0.0;
        for (int y = -kReach; y <= kReach; ++y)
          for (int x = -kReach; x <= kReach; ++x) {
            const double rise_mm = l.after.at(i + x, j + y) - l.before.at(i + x, j + y);
            double& m = mean.mean_mm[y + kReach][x + kReach];
            m += (rise_mm - m) / mean.n;
            sum += rise_mm;
          }
        own[place].push_back(l.after.at(i, j) - l.before.at(i, j));
        all.push_back(sum);
      }
    for (std::size_t c = 0; c < g.size(); ++c) earlier.cells[c] = earlier.cells[c] | l.fired.cells[c];
  }
  p.drop_height = repeats_of(all);
  for (std::size_t n = 0; n < p.places.size(); ++n) p.places[n].own = repeats_of(own[n]);
  if (!p.complete() || !(p.drop_height.mean_mm > 0.0)) return p;
  for (PlaceRise& place : p.places) place.kernel = nearest_kernel(place.rise, p.drop_height.mean_mm);
  const OffsetKernel& c = p.places[0].kernel;
  p.centre = {c.at(0, 0), 0.25 * (c.at(1, 0) + c.at(-1, 0) + c.at(0, 1) + c.at(0, -1)),
              0.25 * (c.at(1, 1) + c.at(-1, 1) + c.at(1, -1) + c.at(-1, -1))};
  for (int n = 0; n < table.size(); ++n) {
    PlaceRise& place = p.places[std::size_t(n)];
    const OffsetKernel mixed = deposition::mixed_kernel(p.centre, table[n]);
    for (int k = 0; k < OffsetKernel::kCells; ++k)
      place.mixed_error = std::max(place.mixed_error, std::abs(place.kernel.height_mm[std::size_t(k)] -
                                                               mixed.height_mm[std::size_t(k)]) /
                                                          p.drop_height.mean_mm);
  }
  return p;
}

}  // namespace firn::droplet
