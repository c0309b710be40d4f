#include "core/slice/mesh/columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::slice {
namespace {

// A line along z through (x, y) in half units. Both are odd, so that it meets no vertex.
struct Line {
  std::int64_t x, y;
};

std::int64_t half_units(double mm) { return 2 * std::int64_t(std::floor(mm * geometry::kUnitsPerMm)) + 1; }

/// Computes intersections of a facet with vertical lines. Seen from above its corners run counter-clockwise.
/// A line through the common edge of two facets belongs to one of them: the one for which the edge runs down,
/// or to the left if it is level.
class Projection {
 public:
  Projection(const Vertex& a, Vertex b, Vertex c) : a_(a) {
    area_ = (std::int64_t(b.x) - a.x) * (std::int64_t(c.y) - a.y) -
            (std::int64_t(c.x) - a.x) * (std::int64_t(b.y) - a.y);
    if (area_ < 0) std::swap(b, c);
    b_ = b;
    c_ = c;
  }
  /// +1: seen from above (upward leaves the body), -1: from below, 0: edge on.
  int side() const { return (area_ > 0) - (area_ < 0); }

  bool meets(const Line& line, double& z) const {
    const __int128 over_a = beside(b_, c_, line), over_b = beside(c_, a_, line),
                   over_c = beside(a_, b_, line);
    if (over_a < 0 || over_b < 0 || over_c < 0) return false;
    if ((over_a == 0 && !owns(b_, c_)) || (over_b == 0 && !owns(c_, a_)) || (over_c == 0 && !owns(a_, b_)))
      return false;
    z = (double(over_a) * a_.z + double(over_b) * b_.z + double(over_c) * c_.z) /
        double(over_a + over_b + over_c);
    return true;
  }

 private:
  static __int128 beside(const Vertex& p, const Vertex& q, const Line& line) {
    return __int128(2 * (std::int64_t(q.x) - p.x)) * (line.y - 2 * std::int64_t(p.y)) -
           __int128(2 * (std::int64_t(q.y) - p.y)) * (line.x - 2 * std::int64_t(p.x));
  }
  static bool owns(const Vertex& p, const Vertex& q) { return q.y < p.y || (q.y == p.y && q.x < p.x); }

  Vertex a_, b_, c_;
  std::int64_t area_;
};

// Interleaves the bits of x and y.
std::uint64_t z_order(const Vertex& v) {
  const auto spread = [](std::int32_t number) {
    std::uint64_t bits = std::uint32_t(number) ^ 0x80000000u;
    bits = (bits | bits << 16) & 0x0000ffff0000ffffull;
    bits = (bits | bits << 8) & 0x00ff00ff00ff00ffull;
    bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0full;
    bits = (bits | bits << 2) & 0x3333333333333333ull;
    return (bits | bits << 1) & 0x5555555555555555ull;
  };
  return spread(v.x) | spread(v.y) << 1;
}

struct Crossing {
  double z;
  int side;
};

std::vector<Span> spans_inside(std::vector<Crossing>& crossings, double height_mm) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& p, const Crossing& q) {
    return std::pair(p.z, p.side) < std::pair(q.z, q.side);
  });
  std::vector<Span> spans;
  int turns = 0;
  double from = 0.0;
  for (const Crossing& c : crossings) {
    const int before = std::exchange(turns, turns - c.side);  // from below into the body: +1
    const double z = std::clamp(c.z * geometry::kMmPerUnit, 0.0, height_mm);
    if (before <= 0 && turns > 0) from = z;
    if (before > 0 && turns <= 0 && from < z) {
      if (!spans.empty() && spans.back().to_mm == from)
        spans.back().to_mm = z;
      else
        spans.push_back({from, z});
    }
  }
  return spans;
}

}  // namespace

std::vector<std::vector<Span>> columns(const Mesh& mesh, const GridSpec& grid, double height_mm) {
  std::vector<std::vector<Crossing>> crossings(grid.size());
  const auto first = [](double mm, double origin, double pitch) {
    return std::int64_t(std::ceil((mm - origin) / pitch)) - 1;
  };
  for (const auto& t : mesh.triangles) {
    const Vertex &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Projection projection(a, b, c);
    if (projection.side() == 0) continue;
    const auto [x0, x1] = std::minmax({a.x, b.x, c.x});
    const auto [y0, y1] = std::minmax({a.y, b.y, c.y});
    const std::int64_t i0 =
        std::max<std::int64_t>(0, first(x0 * geometry::kMmPerUnit, grid.origin_x_mm, grid.pitch_x_mm));
    const std::int64_t i1 = std::min<std::int64_t>(
        grid.nx - 1, first(x1 * geometry::kMmPerUnit, grid.origin_x_mm, grid.pitch_x_mm) + 1);
    const std::int64_t j0 =
        std::max<std::int64_t>(0, first(y0 * geometry::kMmPerUnit, grid.origin_y_mm, grid.pitch_y_mm));
    const std::int64_t j1 = std::min<std::int64_t>(
        grid.ny - 1, first(y1 * geometry::kMmPerUnit, grid.origin_y_mm, grid.pitch_y_mm) + 1);
    for (std::int64_t j = j0; j <= j1; ++j)
      for (std::int64_t i = i0; i <= i1; ++i) {
        double z;
        if (projection.meets({half_units(grid.x_mm(int(i))), half_units(grid.y_mm(int(j)))}, z))
          crossings[std::size_t(j) * std::size_t(grid.nx) + std::size_t(i)].push_back({z, projection.side()});
      }
  }
  std::vector<std::vector<Span>> spans;
  spans.reserve(crossings.size());
  for (std::vector<Crossing>& column : crossings) spans.push_back(spans_inside(column, height_mm));
  return spans;
}

// Sorts the facets along the Z-order curve of their first corners, so that neighbours in the list lie near
// each other.
MeshSolid::MeshSolid(Mesh mesh) : mesh_(std::move(mesh)) {
  std::sort(mesh_.triangles.begin(), mesh_.triangles.end(), [&](const auto& s, const auto& t) {
    return z_order(mesh_.vertices[s[0]]) < z_order(mesh_.vertices[t[0]]);
  });
  tree_.resize(mesh_.triangles.size());
  for (std::size_t n = 0; n < mesh_.triangles.size(); ++n) {
    geometry::BoxOf<std::int32_t> box;
    for (const std::uint32_t v : mesh_.triangles[n]) box.add(mesh_.vertices[v].x, mesh_.vertices[v].y);
    tree_.set(n, box);
  }
  tree_.build();
}

bool MeshSolid::contains(double x_mm, double y_mm, double z_mm) const {
  if (!(std::abs(x_mm) < 1e5 && std::abs(y_mm) < 1e5)) return false;
  const Line line{half_units(x_mm), half_units(y_mm)};
  const auto x = std::int32_t(line.x >> 1), y = std::int32_t(line.y >> 1);
  int turns = 0;
  tree_.touching({x, y, x + 1, y + 1}, [&](std::size_t n) {
    const auto& t = mesh_.triangles[n];
    const Projection projection(mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]);
    double z;
    if (projection.side() != 0 && projection.meets(line, z) && z > z_mm * geometry::kUnitsPerMm)
      turns += projection.side();
  });
  return turns > 0;
}

}  // namespace firn::slice
