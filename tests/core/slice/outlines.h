// Outlines for the tests of the slicer's paths, made by formulas.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/geometry/planar.h"
#include "core/geometry/region.h"
#include "core/geometry/vec.h"
#include "core/grid/random.h"

namespace firn::slice::outlines {

inline constexpr double kPi = 3.14159265358979323846;

inline geometry::Point at_mm(double x, double y) {
  return geometry::to_point({x * geometry::kUnitsPerMm, y * geometry::kUnitsPerMm});
}

inline void add_circle(geometry::Region& region, double x, double y, double r, int n, bool hole = false,
                       double phase = 0) {
  std::vector<geometry::Point> ring;
  for (int i = 0; i < n; ++i) {
    const double a = phase + 2 * kPi * (hole ? n - i : i) / n;
    ring.push_back(at_mm(x + r * std::cos(a), y + r * std::sin(a)));
  }
  region.add(ring);
}

inline void add_polygon(geometry::Region& region, const std::vector<std::pair<double, double>>& corners) {
  std::vector<geometry::Point> ring;
  for (const auto& [x, y] : corners) ring.push_back(at_mm(x, y));
  region.add(ring);
}

inline void add_box(geometry::Region& region, double x0, double y0, double x1, double y1, bool hole = false) {
  if (hole)
    add_polygon(region, {{x0, y0}, {x0, y1}, {x1, y1}, {x1, y0}});
  else
    add_polygon(region, {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}});
}

inline geometry::Region gear() {
  geometry::Region region;
  std::vector<geometry::Point> ring;
  for (int i = 0; i < 4 * 14; ++i) {
    const double a = 2 * kPi * (i + 0.13) / (4 * 14), r = i % 4 < 2 ? 25.0 : 20.5;
    ring.push_back(at_mm(r * std::cos(a), r * std::sin(a)));
  }
  region.add(ring);
  add_circle(region, 0, 0, 6, 40, true);
  return region;
}

inline geometry::Region torus_slice() {
  geometry::Region region;
  add_circle(region, 0, 0, 30, 120);
  add_circle(region, 0.4, 0.2, 14, 70, true);
  return region;
}

inline geometry::Region nested_shells() {
  geometry::Region region;
  for (int shell = 0; shell < 5; ++shell)
    add_circle(region, 0.3 * shell, 0, 30 - 5.3 * shell, 90 - 11 * shell, shell % 2);
  return region;
}

// Slots of many widths, one of them exactly two first offsets wide.
inline geometry::Region comb() {
  std::vector<std::pair<double, double>> corners{{0, 0}, {60, 0}, {60, 25}};
  const double widths[] = {1.2, 2.9, 0.4, 5.7, 1.19, 3.0, 2.4};
  double x = 58;
  for (const double w : widths) {
    corners.insert(corners.end(), {{x, 25}, {x, 5}, {x - w, 5}, {x - w, 25}});
    x -= w + 3.3;
  }
  corners.push_back({0, 25});
  geometry::Region region;
  add_polygon(region, corners);
  return region;
}

// A star about the origin with n random radii: reflex and convex corners, some very sharp.
inline geometry::Region random_star(std::uint64_t seed, int n, double low = 8, double high = 30) {
  std::vector<geometry::Point> ring;
  for (int i = 0; i < n; ++i) {
    const double u = random_uniform({seed, Purpose::kTest, 0, 0, std::uint32_t(i)});
    const double a = 2 * kPi * i / n, r = low + (high - low) * u;
    ring.push_back(at_mm(r * std::cos(a), r * std::sin(a)));
  }
  geometry::Region region;
  region.add(ring);
  return region;
}

// A wavy blob with holes of the same kind, as scanned sculptures have.
inline geometry::Region blob(std::uint64_t seed) {
  const auto wave = [&](double r0, double x, double y, std::uint32_t key, int n, bool hole) {
    std::vector<geometry::Point> ring;
    double phase[5], size[5];
    for (std::uint32_t k = 0; k < 5; ++k) {
      phase[k] = 2 * kPi * random_uniform({seed, Purpose::kTest, key, 1, k});
      size[k] = 0.13 * random_uniform({seed, Purpose::kTest, key, 2, k});
    }
    for (int i = 0; i < n; ++i) {
      const double a = 2 * kPi * i / n;
      double r = 1;
      for (int k = 0; k < 5; ++k) r += size[k] * std::sin((2 * k + 2) * a + phase[k]);
      ring.push_back(at_mm(x + r0 * r * std::cos(a), y + r0 * r * std::sin(a)));
    }
    if (hole) std::reverse(ring.begin(), ring.end());
    return ring;
  };
  geometry::Region region;
  region.add(wave(35, 0, 0, 1, 230, false));
  region.add(wave(5, -8, 3, 2, 60, true));
  region.add(wave(4, 10, -4, 3, 50, true));
  return region;
}

struct Named {
  std::string name;
  geometry::Region region;
};
inline std::vector<Named> all() {
  std::vector<Named> list{
      {"gear", gear()}, {"torus", torus_slice()}, {"shells", nested_shells()}, {"comb", comb()}};
  for (std::uint64_t s = 1; s <= 6; ++s)
    list.push_back({"star " + std::to_string(s), random_star(s, int(20 + 15 * s))});
  for (std::uint64_t s = 1; s <= 3; ++s) list.push_back({"blob " + std::to_string(s), blob(s)});
  return list;
}

// An area along the x axis between two rough walls, n steps from `end_mm` to - `end_mm`. @param half_mm (x)
// half its width in mm
template <class Half>
geometry::Region between_walls(double end_mm, int n, RandomStream& random, const Half& half_mm) {
  std::vector<geometry::Point> ring;
  const auto add = [&](int i, int side) {
    const double x = end_mm - 2 * end_mm * i / n;
    ring.push_back(geometry::to_point({1e4 * x, 1e4 * (side * half_mm(x) + random.uniform(-0.01, 0.01))}));
  };
  for (int i = 0; i <= n; ++i) add(i, 1);
  for (int i = n; i >= 0; --i) add(i, -1);
  geometry::Rings rings;
  rings.add(ring);
  return region_of(rings);
}

// Two wide areas and between them a strait, narrowest in its middle, where half its width is about `half_mm`;
// its walls bend in a radius of 5 to 80 mm and are rough by 0.01 mm.
inline geometry::Region hourglass(double half_mm, RandomStream& random) {
  const double half = half_mm + random.uniform(-0.02, 0.03), radius_mm = random.uniform(5, 80);
  return between_walls(30, 300, random,
                       [=](double x) { return half + std::min(x * x / (2 * radius_mm), 6.0); });
}

}  // namespace firn::slice::outlines
