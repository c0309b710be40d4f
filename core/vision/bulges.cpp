#include "core/vision/bulges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace firn::vision {
namespace {

constexpr double kCore = 0.6;  // share of the inscribed radius that a core keeps from the outline
constexpr int kFar = 1 << 20;

void fill_holes(Silhouette& s) {
  // Ground that is connected to the lattice's rim, four neighbours, is no hole.
  std::vector<std::uint8_t> outside(s.mask.size());
  std::vector<int> stack;
  const auto seed = [&](int i, int j) {
    const int k = j * s.columns + i;
    if (!s.mask[std::size_t(k)] && !outside[std::size_t(k)]) {
      outside[std::size_t(k)] = 1;
      stack.push_back(k);
    }
  };
  for (int i = 0; i < s.columns; ++i) {
    seed(i, 0);
    seed(i, s.rows - 1);
  }
  for (int j = 0; j < s.rows; ++j) {
    seed(0, j);
    seed(s.columns - 1, j);
  }
  while (!stack.empty()) {
    const int k = stack.back(), i = k % s.columns, j = k / s.columns;
    stack.pop_back();
    if (i > 0) seed(i - 1, j);
    if (i + 1 < s.columns) seed(i + 1, j);
    if (j > 0) seed(i, j - 1);
    if (j + 1 < s.rows) seed(i, j + 1);
  }
  for (std::size_t k = 0; k < s.mask.size(); ++k) s.mask[k] = !outside[k];
}

// Squared distance of each cell to the nearest cell off the mask [Meijster, Roerdink and Hesselink 2000].
// Beyond the lattice lies ground, beyond the picture's edge nothing.
std::vector<int> squared_distances(const Silhouette& s) {
  const int w = s.columns, h = s.rows;
  std::vector<int> column(s.mask.size()), result(s.mask.size());
  for (int x = 0; x < w; ++x) {
    int d = s.top ? kFar : 0;
    for (int y = 0; y < h; ++y) {
      const std::size_t k = std::size_t(y) * std::size_t(w) + std::size_t(x);
      d = s.mask[k] ? std::min(kFar, d + 1) : 0;
      column[k] = d;
    }
    d = s.bottom ? kFar : 0;
    for (int y = h - 1; y >= 0; --y) {
      const std::size_t k = std::size_t(y) * std::size_t(w) + std::size_t(x);
      d = s.mask[k] ? std::min(kFar, d + 1) : 0;
      column[k] = std::min(column[k], d);
    }
  }
  // Lower envelope of parabolas in each row; position -1 and w are ground unless the picture ends there.
  std::vector<int> at, from;
  for (int y = 0; y < h; ++y) {
    const int first = s.left ? 0 : -1, last = s.right ? w - 1 : w;
    const auto g = [&](int x) -> long {
      if (x < 0 || x >= w) return 0;
      return column[std::size_t(y) * std::size_t(w) + std::size_t(x)];
    };
    const auto value = [&](int x, int i) { return long(x - i) * (x - i) + g(i) * g(i); };
    at.clear();
    from.clear();
    for (int u = first; u <= last; ++u) {
      while (!at.empty() && value(from.back(), at.back()) > value(from.back(), u)) {
        at.pop_back();
        from.pop_back();
      }
      if (at.empty()) {
        at.push_back(u);
        from.push_back(first);
      } else {
        const long i = at.back();
        const long numerator = long(u) * u - i * i + g(u) * g(u) - g(int(i)) * g(int(i)),
                   denominator = 2 * (u - i);
        const long cut =
            1 + (numerator >= 0 ? numerator / denominator : -((-numerator + denominator - 1) / denominator));
        if (cut <= last) {
          at.push_back(u);
          from.push_back(int(std::max<long>(cut, first)));
        }
      }
    }
    std::size_t q = at.size() - 1;
    for (int x = last; x >= first; --x) {
      while (q > 0 && x < from[q]) --q;
      if (x >= 0 && x < w)
        result[std::size_t(y) * std::size_t(w) + std::size_t(x)] =
            int(std::min<long>(value(x, at[q]), 1L << 30));
    }
  }
  return result;
}

struct Peaks {
  std::vector<int> label;  // bulge of each cell, -1 off the mask
  std::vector<int> peak;   // cell of each bulge
};

// Cells enter from the farthest to the nearest to the outline, and join what they touch.
Peaks divide(const Silhouette& s, const std::vector<int>& distance, double neck) {
  Peaks result;
  const int w = s.columns;
  std::vector<std::uint64_t> order;  // falling distance above the cell's number
  for (std::size_t k = 0; k < s.mask.size(); ++k)
    if (s.mask[k]) order.push_back(std::uint64_t(std::uint32_t(INT32_MAX - distance[k])) << 32 | k);
  std::sort(order.begin(), order.end());
  result.label.assign(s.mask.size(), -1);
  std::vector<int> alias;      // bulges that were given up point to what took them
  std::vector<int> connected;  // sets of bulges that touch each other by now
  const auto root = [](std::vector<int>& parent, int i) {
    while (parent[std::size_t(i)] != i)
      i = parent[std::size_t(i)] = parent[std::size_t(parent[std::size_t(i)])];
    return i;
  };
  for (const std::uint64_t entry : order) {
    const int k = int(entry & 0xFFFFFFFF), i = k % w, j = k / w;
    int own = -1;
    for (int dj = -1; dj <= 1; ++dj)
      for (int di = -1; di <= 1; ++di) {
        const int x = i + di, y = j + dj;
        if ((di == 0 && dj == 0) || x < 0 || y < 0 || x >= w || y >= s.rows) continue;
        const int l = result.label[std::size_t(y) * std::size_t(w) + std::size_t(x)];
        if (l < 0) continue;
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
        if (saddle > neck * smaller || smaller < 1.6) {
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
  std::vector<std::uint8_t> in(s.mask.size());
  std::vector<int> core{peak};
  in[std::size_t(peak)] = 1;
  double sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (std::size_t n = 0; n < core.size(); ++n) {
    const int k = core[n], i = k % w, j = k / w;
    sx += i;
    sy += j;
    sxx += double(i) * i;
    sxy += double(i) * j;
    syy += double(j) * j;
    b.at_edge |=
        (i == 0 && s.left) || (j == 0 && s.top) || (i == w - 1 && s.right) || (j == s.rows - 1 && s.bottom);
    for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int x = i + di, y = j + dj, l = y * w + x;
      if (x < 0 || y < 0 || x >= w || y >= s.rows || in[std::size_t(l)]) continue;
      if (peaks.label[std::size_t(l)] != number || double(distance[std::size_t(l)]) <= keep * keep) continue;
      in[std::size_t(l)] = 1;
      core.push_back(l);
    }
  }
  const double n = double(core.size()), cx = sx / n, cy = sy / n;
  const double vxx = sxx / n - cx * cx + 1.0 / 12, vyy = syy / n - cy * cy + 1.0 / 12,
               vxy = sxy / n - cx * cy;
  const double mean = 0.5 * (vxx + vyy), spread = std::sqrt(0.25 * (vxx - vyy) * (vxx - vyy) + vxy * vxy);
  const double large = 2 * std::sqrt(mean + spread) + keep,
               small = 2 * std::sqrt(std::max(0.0, mean - spread)) + keep;
  b.elongation = large / small;
  double far = 0.0;
  long cells = 0;
  for (std::size_t k = 0; k < s.mask.size(); ++k) {
    if (peaks.label[k] != number) continue;
    ++cells;
    const double dx = double(int(k) % w) - cx, dy = double(int(k) / w) - cy, d = dx * dx + dy * dy;
    if (d > far) {
      far = d;
      b.tail = {s.x0 + (double(int(k) % w) + 0.5) * s.scale - 0.5,
                s.y0 + (double(int(k) / w) + 0.5) * s.scale - 0.5};
    }
  }
  b.cells = cells;
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
