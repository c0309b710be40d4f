// Reference results for the slicer, computed without its code.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/region.h"
#include "tests/core/slice/meshes.h"

namespace firn::test {

/// Every pair of edges, in 128 bits. Rings of a Region may meet in single points that are corners of both;
/// everything else is named. Empty: in order.
inline std::string crossing_by_all_pairs(const geometry::Rings& rings) {
  struct E {
    __int128 ax, ay, bx, by;
    std::size_t ring;
  };
  std::vector<E> edges;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const auto ring = rings[r];
    if (ring.size() < 3) return "ring " + std::to_string(r) + " has fewer than three points";
    std::set<std::pair<int, int>> seen;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const auto &p = ring[i], &q = ring[(i + 1) % ring.size()];
      if (!seen.insert({p.x, p.y}).second) return "ring " + std::to_string(r) + " meets a point twice";
      edges.push_back({p.x, p.y, q.x, q.y, r});
    }
  }
  const auto side = [](const E& e, __int128 x, __int128 y) {
    const __int128 v = (e.bx - e.ax) * (y - e.ay) - (e.by - e.ay) * (x - e.ax);
    return (v > 0) - (v < 0);
  };
  const auto within = [](const E& e, __int128 x, __int128 y) {
    return std::min(e.ax, e.bx) <= x && x <= std::max(e.ax, e.bx) && std::min(e.ay, e.by) <= y &&
           y <= std::max(e.ay, e.by);
  };
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (std::size_t j = i + 1; j < edges.size(); ++j) {
      const E &e = edges[i], &f = edges[j];
      const std::string where = " (rings " + std::to_string(e.ring) + " and " + std::to_string(f.ring) + ")";
      const int a = side(e, f.ax, f.ay), b = side(e, f.bx, f.by), c = side(f, e.ax, e.ay),
                d = side(f, e.bx, e.by);
      if (a * b < 0 && c * d < 0) return "edges cross" + where;
      const auto inner = [&](const E& g, int s, __int128 x, __int128 y) {  // a corner within the other edge
        return s == 0 && within(g, x, y) && !(x == g.ax && y == g.ay) && !(x == g.bx && y == g.by);
      };
      if (inner(e, a, f.ax, f.ay) || inner(e, b, f.bx, f.by) || inner(f, c, e.ax, e.ay) ||
          inner(f, d, e.bx, e.by))
        return "a corner lies on an edge" + where;
      if ((e.ax == f.ax && e.ay == f.ay && e.bx == f.bx && e.by == f.by) ||
          (e.ax == f.bx && e.ay == f.by && e.bx == f.ax && e.by == f.ay))
        return "an edge comes twice" + where;
    }
  return "";
}

/// A mesh's section at height z, from its facets one by one, in double.
class Section {
 public:
  Section(const SampleMesh& m, double z) {
    for (const auto& t : m.triangles) {
      std::array<double, 4> way{};  // enters over the facet's falling edge, leaves over the rising one
      int crossed = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto &a = m.vertices[t[k]], &b = m.vertices[t[(k + 1) % 3]];
        if ((double(a[2]) < z) == (double(b[2]) < z)) continue;
        const double s = (z - a[2]) / (double(b[2]) - a[2]);
        const std::size_t end = double(a[2]) < z ? 2 : 0;
        way[end] = a[0] + s * (double(b[0]) - a[0]);
        way[end + 1] = a[1] + s * (double(b[1]) - a[1]);
        ++crossed;
      }
      if (crossed == 2) ways_.push_back(way);
    }
  }
  int winding(double x, double y) const {
    int turns = 0;
    for (const auto& [x0, y0, x1, y1] : ways_) {
      const double side = (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0);
      if (y0 <= y && y1 > y && side > 0) ++turns;
      if (y0 > y && y1 <= y && side < 0) --turns;
    }
    return turns;
  }
  /// Area of positive winding number by rows of the given height, each along its middle.
  double area(double row_mm) const {
    double low = 1e300, high = -1e300, sum = 0.0;
    for (const auto& [x0, y0, x1, y1] : ways_) {
      low = std::min({low, y0, y1});
      high = std::max({high, y0, y1});
    }
    std::vector<std::vector<std::pair<double, int>>> rows(
        ways_.empty() ? 0 : std::size_t((high - low) / row_mm) + 1);
    for (const auto& [x0, y0, x1, y1] : ways_)
      for (std::size_t r = std::size_t((std::min(y0, y1) - low) / row_mm); r < rows.size(); ++r) {
        const double y = low + (double(r) + 0.5) * row_mm;
        if (y >= std::max(y0, y1)) break;
        if (y >= std::min(y0, y1))
          rows[r].push_back({x0 + (y - y0) / (y1 - y0) * (x1 - x0), y1 > y0 ? -1 : 1});
      }
    for (auto& row : rows) {
      std::sort(row.begin(), row.end());
      int turns = 0;
      for (std::size_t i = 0; i + 1 < row.size(); ++i) {
        turns += row[i].second;  // from the left into the area over a side that runs down
        if (turns > 0) sum += (row[i + 1].first - row[i].first) * row_mm;
      }
    }
    return sum;
  }

 private:
  std::vector<std::array<double, 4>> ways_;
};

inline double volume_by_tetrahedra(const SampleMesh& m) {
  double sum = 0.0;
  for (const auto& t : m.triangles) {
    const auto &a = m.vertices[t[0]], &b = m.vertices[t[1]], &c = m.vertices[t[2]];
    sum += double(a[0]) * (double(b[1]) * c[2] - double(b[2]) * c[1]) -
           double(a[1]) * (double(b[0]) * c[2] - double(b[2]) * c[0]) +
           double(a[2]) * (double(b[0]) * c[1] - double(b[1]) * c[0]);
  }
  return sum / 6.0;
}

}  // namespace firn::test
