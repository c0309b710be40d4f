#include "core/grid/edge_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace firn {
namespace {

constexpr double kLow = 0.1, kHalf = 0.5, kHigh = 0.9;  // of the target's height
constexpr int kFullParts = 4;         // a quarter of the part has to reach kHigh, else it is not printed yet
constexpr int kMinSide = 6;           // cells of a straight side at a corner
constexpr double kCornerStep = 0.05;  // pitches of the search along the bisector
constexpr double kCornerReach = 3.0;  // pitches beyond the sharp corner where it begins

// The target's height in every cell: of the part its own, beyond it that of the nearest cell of the part,
// ring by ring.
HeightMap extended(const HeightMap& target, const Mask& mask) {
  const GridSpec& g = mask.spec;
  HeightMap out(g, kNotMeasured);
  std::vector<std::size_t> front, next;
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c]) {
      out.cells[c] = target.cells[c];
      front.push_back(c);
    }
  constexpr std::array<std::array<int, 2>, 8> kSidesFirst{
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
  while (!front.empty()) {
    next.clear();
    for (const auto& [di, dj] : kSidesFirst)
      for (const std::size_t c : front) {
        const int i = int(c % std::size_t(g.nx)) + di, j = int(c / std::size_t(g.nx)) + dj;
        if (!g.contains(i, j) || !std::isnan(out.at(i, j))) continue;
        out.at(i, j) = out.cells[c];
        next.push_back(g.index(i, j));
      }
    std::swap(front, next);
  }
  return out;
}

// Surface over target; NaN where either is not known.
HeightMap shares(const HeightMap& height, const HeightMap& target, const Mask& mask) {
  HeightMap share = extended(target, mask);
  for (std::size_t c = 0; c < share.size(); ++c)
    share.cells[c] = share.cells[c] > 0.0 ? height.cells[c] / share.cells[c] : kNotMeasured;
  return share;
}

struct Corner3 {
  double x, y, value;
};

double cross(const Corner3& o, const Corner3& a, const Corner3& b) {
  return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
}

Corner3 crossing(const Corner3& a, const Corner3& b, double level) {
  const double t = (level - a.value) / (b.value - a.value);
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), level};
}

// Area of a triangle whose linear surface is at or above a level, and length of the level's contour in it.
struct Cut {
  double area = 0.0, length = 0.0;
};

Cut cut(std::array<Corner3, 3> t, double level) {
  std::ranges::sort(t, {}, &Corner3::value);
  const double whole = 0.5 * std::abs(cross(t[0], t[1], t[2]));
  if (level <= t[0].value) return {whole, 0.0};
  if (level > t[2].value) return {};
  const Corner3 far = crossing(t[0], t[2], level);
  const bool upper = t[1].value < level;  // the tip above the level is a triangle, else the rest below it
  const Corner3 near = upper ? crossing(t[1], t[2], level) : crossing(t[0], t[1], level);
  const double tip = 0.5 * std::abs(cross(upper ? t[2] : t[0], near, far));
  return {upper ? tip : whole - tip,
          std::sqrt((far.x - near.x) * (far.x - near.x) + (far.y - near.y) * (far.y - near.y))};
}

// Calls `use` with the four triangles between each four cells that are all known.
template <class Use>
void each_triangle(const HeightMap& share, Use use) {
  const GridSpec& g = share.spec;
  for (int j = 0; j + 1 < g.ny; ++j)
    for (int i = 0; i + 1 < g.nx; ++i) {
      const auto at = [&](int a, int b) {
        return Corner3{g.x_mm(i + a), g.y_mm(j + b), share.at(i + a, j + b)};
      };
      const std::array<Corner3, 4> ring{at(0, 0), at(1, 0), at(1, 1), at(0, 1)};
      Corner3 middle{g.x_mm(i) + 0.5 * g.pitch_x_mm, g.y_mm(j) + 0.5 * g.pitch_y_mm, 0.0};
      for (const Corner3& c : ring) middle.value += 0.25 * c.value;
      if (!std::isfinite(middle.value)) continue;
      for (std::size_t n = 0; n < 4; ++n) use(std::array<Corner3, 3>{ring[n], ring[(n + 1) % 4], middle});
    }
}

// A convex corner of the outline: its cell, and the directions from there out of the part.
struct OutlineCorner {
  int i, j, out_x, out_y, side_x, side_y;  // side: cells of the straight sides along x and y
};

// Cells of the part from (i, j) on in direction (di, dj) whose neighbours in direction (oi, oj) are beside
// it.
int straight(const Mask& mask, int i, int j, int di, int dj, int oi, int oj) {
  const auto part = [&](int a, int b) { return mask.spec.contains(a, b) && mask.at(a, b) != 0; };
  int n = 0;
  while (part(i + n * di, j + n * dj) && !part(i + n * di + oi, j + n * dj + oj)) ++n;
  return n;
}

std::vector<OutlineCorner> corners_of(const Mask& mask, int min_side) {
  std::vector<OutlineCorner> found;
  for (int j = 0; j < mask.spec.ny; ++j)
    for (int i = 0; i < mask.spec.nx; ++i) {
      if (!mask.at(i, j)) continue;
      for (const int out_x : {-1, 1})
        for (const int out_y : {-1, 1}) {
          const int along_x = straight(mask, i, j, -out_x, 0, 0, out_y),
                    along_y = straight(mask, i, j, 0, -out_y, out_x, 0);
          if (along_x >= min_side && along_y >= min_side)
            found.push_back({i, j, out_x, out_y, along_x, along_y});
        }
    }
  return found;
}

// The surface's share at a place, between four cells; NaN beyond the grid.
double share_at(const HeightMap& share, double i, double j) {
  const int a = int(std::floor(i)), b = int(std::floor(j));
  if (!share.spec.contains(a, b) || !share.spec.contains(a + 1, b + 1)) return kNotMeasured;
  const double u = i - a, v = j - b;
  return (1 - v) * ((1 - u) * share.at(a, b) + u * share.at(a + 1, b)) +
         v * ((1 - u) * share.at(a, b + 1) + u * share.at(a + 1, b + 1));
}

// Place outwards from (i, j) along one axis at which the surface falls below half [cells]; NaN: nowhere.
double side_at(const HeightMap& share, int i, int j, int di, int dj) {
  for (;; i += di, j += dj) {
    if (!share.spec.contains(i + di, j + dj)) return kNotMeasured;
    const double here = share.at(i, j), next = share.at(i + di, j + dj);
    if (here >= kHalf && next < kHalf) return (di != 0 ? i : j) + (di + dj) * (here - kHalf) / (here - next);
  }
}

// Distance along the bisector from the sharp corner to the surface's half height, over sqrt(2) - 1.
double radius_at(const HeightMap& share, const OutlineCorner& c) {
  const GridSpec& g = share.spec;
  // The sides are taken in their middles, away from the rounding, outwards from well inside the part.
  const int i = c.i - c.out_x * (c.side_x / 2), j = c.j - c.out_y * (c.side_y / 2);
  const double x = side_at(share, i, j, c.out_x, 0), y = side_at(share, i, j, 0, c.out_y);
  if (std::isnan(x) || std::isnan(y)) return kNotMeasured;
  const double step_mm = kCornerStep * std::min(g.pitch_x_mm, g.pitch_y_mm);
  const double step_x = step_mm / g.pitch_x_mm * c.out_x, step_y = step_mm / g.pitch_y_mm * c.out_y;
  const int last = int(0.5 * std::min(c.side_x, c.side_y) / kCornerStep);
  double before = kNotMeasured;
  for (int n = -int(kCornerReach / kCornerStep); n <= last; ++n) {
    const double here = share_at(share, x - n * step_x, y - n * step_y);
    if (here >= kHalf && before < kHalf) {
      const double steps = n - (here - kHalf) / (here - before);
      return steps * step_mm * std::sqrt(2.0) / (std::sqrt(2.0) - 1.0);
    }
    before = here;
  }
  return kNotMeasured;
}

}  // namespace

double edge_width_mm(const HeightMap& height, const HeightMap& target, const Mask& mask) {
  const HeightMap share = shares(height, target, mask);
  std::int64_t full = 0;
  for (std::size_t c = 0; c < share.size(); ++c) full += mask.cells[c] && share.cells[c] >= kHigh;
  if (kFullParts * full < mask.count()) return kNotMeasured;
  double between = 0.0, length = 0.0;
  each_triangle(share, [&](const std::array<Corner3, 3>& t) {
    between += cut(t, kLow).area - cut(t, kHigh).area;
    length += cut(t, kHalf).length;
  });
  return length > 0.0 ? between / length : kNotMeasured;
}

double corner_radius_mm(const HeightMap& height, const HeightMap& target, const Mask& mask, int parts) {
  const std::vector<OutlineCorner> corners = corners_of(mask, kMinSide * parts);
  if (corners.empty()) return kNotMeasured;
  const HeightMap share = shares(height, target, mask);
  double sum = 0.0;
  int n = 0;
  for (const OutlineCorner& c : corners)
    if (const double r = radius_at(share, c); std::isfinite(r)) {
      sum += r;
      ++n;
    }
  return n > 0 ? sum / n : kNotMeasured;
}

}  // namespace firn
