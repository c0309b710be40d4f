#include "estimators/droplet/place_prints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace firn::droplet {
namespace {

using deposition::OffsetKernel;
constexpr int kReach = OffsetKernel::kRadius;
constexpr int kLeastHeights = 3;
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

// Rise of the lines at the distances v from the droplet, in pitches, ascending.
struct Line {
  double v = 0.0, rise_mm = 0.0;
};

// Slope at line n of the parabola through it and its two neighbours.
double slope(const std::vector<Line>& l, std::size_t n) {
  const auto between = [&](std::size_t k) {
    return (l[k + 1].rise_mm - l[k].rise_mm) / (l[k + 1].v - l[k].v);
  };
  if (n == 0) return between(0);
  if (n + 1 == l.size()) return between(n - 1);
  const double before = l[n].v - l[n - 1].v, after = l[n + 1].v - l[n].v;
  return (before * between(n) + after * between(n - 1)) / (before + after);
}

// Integral over [from, to] of the function that is a cubic with these slopes between the lines and 0 outside
// them.
double integral(const std::vector<Line>& lines, double from, double to) {
  double sum = 0.0;
  for (std::size_t n = 1; n < lines.size(); ++n) {
    const Line &a = lines[n - 1], &b = lines[n];
    const double lo = std::max(from, a.v), hi = std::min(to, b.v), h = b.v - a.v;
    if (!(lo < hi)) continue;
    const double da = h * slope(lines, n - 1), db = h * slope(lines, n);
    const auto at = [&](double v) {
      const double t = (v - a.v) / h, u = 1.0 - t;
      return u * u * ((1.0 + 2.0 * t) * a.rise_mm + t * da) + t * t * ((1.0 + 2.0 * u) * b.rise_mm - u * db);
    };
    sum += (at(lo) + 4.0 * at(0.5 * (lo + hi)) + at(hi)) / 6.0 *
           (hi - lo);  // Simpson's rule is exact for a cubic
  }
  return sum;
}

// Droplets of one size at one place along x.
struct Column {
  double x = 0.0;
  bool small = false;
  bool has(const OffsetTable& table, int n) const { return table[n].x == x && table.small(n) == small; }
};

// The lines of column dx of all of these droplets; those at one distance as their mean.
std::vector<Line> lines_of(const PlacePrints& p, const OffsetTable& table, const Column& of, int dx) {
  std::vector<Line> lines;
  for (int n = 0; n < table.size(); ++n)
    for (int dy = -kReach; dy <= kReach && of.has(table, n); ++dy)
      lines.push_back({dy - table[n].y, p.places[std::size_t(n)].rise.mean_mm[dy + kReach][dx + kReach]});
  std::ranges::sort(lines, {}, &Line::v);
  return lines;
}

int heights_of(const OffsetTable& table, const Column& of) {
  int n = 0;
  for (int k = 0; k < table.size(); ++k) n += of.has(table, k);
  return n;
}

// The mean kernel of the small droplets nearest to the centre.
OffsetKernel around_the_centre(const std::vector<OffsetKernel>& kernels, const OffsetTable& table) {
  const auto away = [&](int n) { return table[n].x * table[n].x + table[n].y * table[n].y; };
  double least = 1.0;
  for (int n = table.places() + 1; n < table.size(); ++n) least = std::min(least, away(n));
  OffsetKernel mean;
  int count = 0;
  for (int n = table.places() + 1; n < table.size(); ++n) {
    if (away(n) > least + 1e-9) continue;
    ++count;
    for (std::size_t k = 0; k < mean.height_mm.size(); ++k)
      mean.height_mm[k] += (kernels[std::size_t(n)].height_mm[k] - mean.height_mm[k]) / count;
  }
  return mean;
}

}  // namespace

OffsetKernel nearest_kernel(const OffsetKernel& measured, double drop_height_mm) {
  OffsetKernel k = measured;
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
                              const OffsetTable& printed, const OffsetTable& wanted) {
  PlacePrints p;
  p.places.resize(std::size_t(printed.size()));
  std::vector<std::vector<double>> own(p.places.size());
  DropletPattern earlier(layers.empty() ? GridSpec{} : layers.front().fired.spec);
  const GridSpec& g = earlier.spec;
  for (std::size_t n = 0; n < layers.size(); ++n) {
    const PrintedLayer& l = layers[n];
    for (int j = 0; j < g.ny; ++j)
      for (int i = 0; i < g.nx; ++i) {
        if (l.fired.at(i, j) != 1 || !alone(l.fired, earlier, i, j) || !seen(l, i, j)) continue;
        const auto place = std::size_t(offsets[n].of(g.index(i, j)));
        if (place >= p.places.size()) continue;
        Rise& mean = p.places[place].rise;
        ++mean.n;
        ++p.droplets;
        for (int y = -kReach; y <= kReach; ++y)
          for (int x = -kReach; x <= kReach; ++x) {
            double& m = mean.mean_mm[y + kReach][x + kReach];
            m += (l.after.at(i + x, j + y) - l.before.at(i + x, j + y) - m) / mean.n;
          }
        own[place].push_back(l.after.at(i, j) - l.before.at(i, j));
      }
    for (std::size_t c = 0; c < g.size(); ++c) earlier.cells[c] = earlier.cells[c] | l.fired.cells[c];
  }
  for (std::size_t n = 0; n < p.places.size(); ++n) p.places[n].own = repeats_of(own[n]);
  for (int n = 0; n < printed.size(); ++n)
    if (p.places[std::size_t(n)].own.n < 2) {
      p.missing = std::to_string(p.places[std::size_t(n)].own.n) + " droplets alone at place " +
                  std::to_string(n) + ", two at least are needed";
      return p;
    }
  const auto column = [&](int n) { return Column{wanted[n].x, wanted.small(n)}; };
  const int small_centre = wanted.places();  // beyond the table where there is one size
  const bool centre_between = small_centre < wanted.size() && wanted.places() > 1 &&
                              heights_of(printed, column(small_centre)) < kLeastHeights;
  for (int n = 1; n < wanted.size(); ++n)
    if (heights_of(printed, column(n)) < kLeastHeights && !(centre_between && n == small_centre)) {
      p.missing =
          "a map has one line along each row of cells: what a droplet adds between them shows only where "
          "droplets "
          "are at three places along y at least (actuation.offsets = grid, positions_y)";
      return p;
    }
  std::vector<OffsetKernel> means(std::size_t(wanted.size()));
  for (int n = 1; n < wanted.size(); ++n)
    for (int dx = -kReach; dx <= kReach && !(centre_between && n == small_centre); ++dx) {
      const std::vector<Line> lines = lines_of(p, printed, column(n), dx);
      for (int dy = -kReach; dy <= kReach; ++dy) {
        const double middle = dy - wanted[n].y;
        means[std::size_t(n)].height_mm[OffsetKernel::index(dx, dy)] =
            integral(lines, middle - 0.5, middle + 0.5);
      }
    }
  if (centre_between) means[std::size_t(small_centre)] = around_the_centre(means, wanted);
  const bool two_sizes = small_centre < wanted.size();
  for (int n = 1; n < wanted.size(); ++n)
    (wanted.small(n) ? p.small_drop_height_mm : p.drop_height_mm) +=
        means[std::size_t(n)].drop_height_mm() /
        double(wanted.small(n) ? wanted.size() - wanted.places() : wanted.places() - 1);
  if (!(p.drop_height_mm > 0.0) || (two_sizes && !(p.small_drop_height_mm > 0.0))) {
    p.missing = "the maps do not rise under the droplets";
    return p;
  }
  for (int n = 0; n < wanted.size(); ++n)
    p.kernels.push_back(
        nearest_kernel(means[std::size_t(n)], wanted.small(n) ? p.small_drop_height_mm : p.drop_height_mm));
  return p;
}

}  // namespace firn::droplet
