#include "core/vision/bulges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

#include "core/vision/raster.h"

namespace firn::vision {
namespace {

constexpr double kCore = 0.6;           // share of the inscribed radius that a core keeps from the outline
constexpr double kMinPeak_cells = 1.6;  // of the smaller of two peaks: below, a neck is the lattice's step
constexpr double kCellVariance = 1.0 / 12;  // of a cell's own square

struct Peaks {
  std::vector<int> label;  // bulge of each cell, -1 off the mask
  std::vector<int> peak;   // cell of each bulge
};

// The cells of a mask by falling distance, then by number: counted, or sorted where no ground bounds
// distances.
std::vector<int> by_distance(const std::vector<std::uint8_t>& mask, const std::vector<int>& distance) {
  std::vector<int> order;
  int largest = 0;
  for (std::size_t k = 0; k < mask.size(); ++k)
    if (mask[k]) {
      order.push_back(int(k));
      largest = std::max(largest, distance[k]);
    }
  constexpr int kCounted = 1 << 20;
  if (largest >= kCounted) {
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return distance[std::size_t(a)] > distance[std::size_t(b)]; });
    return order;
  }
  std::vector<int> place(std::size_t(largest) + 2);  // of each distance's first cell
  for (const int k : order) ++place[std::size_t(largest - distance[std::size_t(k)]) + 1];
  for (std::size_t d = 1; d < place.size(); ++d) place[d] += place[d - 1];
  std::vector<int> sorted(order.size());
  for (const int k : order) sorted[std::size_t(place[std::size_t(largest - distance[std::size_t(k)])]++)] = k;
  return sorted;
}

// Cells enter from the farthest to the nearest to the outline, and join what they touch.
Peaks divide(const Silhouette& s, const std::vector<int>& distance, double neck) {
  Peaks result;
  const int w = s.columns;
  const std::vector<int> order = by_distance(s.mask, distance);
  result.label.assign(s.mask.size(), -1);
  std::vector<int> alias;      // bulges that were given up point to what took them
  std::vector<int> connected;  // sets of bulges that touch each other by now
  const auto root = [](std::vector<int>& parent, int i) {
    while (parent[std::size_t(i)] != i)
      i = parent[std::size_t(i)] = parent[std::size_t(parent[std::size_t(i)])];
    return i;
  };
  for (const int k : order) {
    const int i = k % w, j = k / w;
    int own = -1, last = -1;
    const int y0 = std::max(0, j - 1), y1 = std::min(s.rows - 1, j + 1), x0 = std::max(0, i - 1),
              x1 = std::min(w - 1, i + 1);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const int l = result.label[std::size_t(y) * std::size_t(w) + std::size_t(x)];
        if (l < 0 || l == last) continue;  // its own label is not set yet
        last = l;
        const int bulge = root(alias, l);
        if (own < 0) {
          own = bulge;
          continue;
        }
        if (bulge == own || root(connected, bulge) == root(connected, own)) continue;
        // The set's deepest bulge decides for it: bulge numbers ascend with smaller radius.
        const int a = std::min(bulge, own), b = std::max(bulge, own);
        const double saddle = std::sqrt(double(distance[std::size_t(k)]));
        const double smaller = std::sqrt(double(distance[std::size_t(result.peak[std::size_t(b)])]));
        connected[std::size_t(root(connected, std::max(a, b)))] = root(connected, std::min(a, b));
        if (saddle > neck * smaller || smaller < kMinPeak_cells) {
          alias[std::size_t(b)] = a;
          own = a;
        }
      }
    if (own < 0) {
      own = int(result.peak.size());
      result.peak.push_back(k);
      alias.push_back(own);
      connected.push_back(own);
    }
    result.label[std::size_t(k)] = own;
  }
  for (int& l : result.label)
    if (l >= 0) l = root(alias, l);
  for (std::size_t b = 0; b < result.peak.size(); ++b)
    if (alias[b] != int(b)) result.peak[b] = -1;
  return result;
}

Bulge measure(const Silhouette& s, const std::vector<int>& distance, const Peaks& peaks, int number) {
  Bulge b;
  const int w = s.columns, peak = peaks.peak[std::size_t(number)];
  const double radius = std::sqrt(double(distance[std::size_t(peak)])), keep = kCore * radius;
  // The core: cells far from the outline that are connected to the peak.
  CellMask far_inside(s.columns, s.rows);
  for (std::size_t k = 0; k < s.mask.size(); ++k)
    far_inside.cells[k] = peaks.label[k] == number && double(distance[k]) > keep * keep;
  const CellSums core = connected_sums(far_inside, peak % w, peak / w);
  b.at_edge =
      (core.left && s.left) || (core.top && s.top) || (core.right && s.right) || (core.bottom && s.bottom);
  const double n = core.n, cx = core.x / n, cy = core.y / n;
  const double vxx = core.xx / n - cx * cx + kCellVariance, vyy = core.yy / n - cy * cy + kCellVariance,
               vxy = core.xy / n - cx * cy;
  const double mean = 0.5 * (vxx + vyy), spread = std::sqrt(0.25 * (vxx - vyy) * (vxx - vyy) + vxy * vxy);
  const double large = 2 * std::sqrt(mean + spread) + keep,
               small = 2 * std::sqrt(std::max(0.0, mean - spread)) + keep;
  b.elongation = large / small;
  double far = 0.0;
  for (std::size_t k = 0; k < s.mask.size(); ++k) {
    if (peaks.label[k] != number) continue;
    const double dx = double(int(k) % w) - cx, dy = double(int(k) / w) - cy, d = dx * dx + dy * dy;
    far = std::max(far, d);
  }
  b.reach_px = s.scale * (std::sqrt(far) + 0.5);
  b.radius_px = s.scale * std::max(0.5, radius - 0.5);
  b.x = s.x0 + (cx + 0.5) * s.scale - 0.5;
  b.y = s.y0 + (cy + 0.5) * s.scale - 0.5;
  return b;
}

}  // namespace

Silhouette make_silhouette(const Scene& scene, const Component& c, double level, int cells) {
  Silhouette s;
  const int w = c.x1 - c.x0 + 1, h = c.y1 - c.y0 + 1;
  while (long((w / s.scale) + 3) * ((h / s.scale) + 3) > cells) ++s.scale;
  const Frame& f = scene.frame();
  s.left = c.x0 == 0;
  s.top = c.y0 == 0;
  s.right = c.x1 == f.width - 1;
  s.bottom = c.y1 == f.height - 1;
  s.x0 = s.left ? 0 : c.x0 - s.scale;
  s.y0 = s.top ? 0 : c.y0 - s.scale;
  s.columns = (c.x1 - s.x0) / s.scale + 1 + (s.right ? 0 : 1);
  s.rows = (c.y1 - s.y0) / s.scale + 1 + (s.bottom ? 0 : 1);
  s.mask.assign(std::size_t(s.columns) * std::size_t(s.rows), 0);
  for (const Run& r : c.runs) {
    const std::size_t row = std::size_t((r.y - s.y0) / s.scale) * std::size_t(s.columns);
    for (int x = r.x0; x <= r.x1; ++x)
      if (scene.opacity(x, r.y) > level) s.mask[row + std::size_t((x - s.x0) / s.scale)] = 1;
  }
  fill_holes(s);
  return s;
}

std::vector<Bulge> find_bulges(const Silhouette& s, double neck) {
  const std::vector<int> distance = squared_distances(s);
  const Peaks peaks = divide(s, distance, neck);
  std::vector<Bulge> bulges;
  for (std::size_t n = 0; n < peaks.peak.size(); ++n)
    if (peaks.peak[n] >= 0) bulges.push_back(measure(s, distance, peaks, int(n)));
  std::stable_sort(bulges.begin(), bulges.end(),
                   [](const Bulge& a, const Bulge& b) { return a.radius_px > b.radius_px; });
  return bulges;
}

}  // namespace firn::vision
