#include "core/slice/mesh/mesh_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace firn::slice {
namespace {

struct Side {  // of an edge, from the facet that has it
  std::uint32_t low, high;
  bool up;
  bool same_edge(const Side& s) const { return low == s.low && high == s.high; }
};

void count_edges(const Mesh& mesh, MeshCheck& out) {
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  std::sort(sides.begin(), sides.end(),
            [](const Side& p, const Side& q) { return p.low != q.low ? p.low < q.low : p.high < q.high; });
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i;
    while (j < sides.size() && sides[j].same_edge(sides[i])) ++j;
    ++out.edges;
    out.border_edges += j - i == 1;
    out.branching_edges += j - i > 2;
    out.against_edges += j - i == 2 && sides[i].up == sides[i + 1].up;
    i = j;
  }
}

std::size_t duplicates(const Mesh& mesh) {
  auto facets = mesh.triangles;
  for (auto& t : facets) std::sort(t.begin(), t.end());
  std::sort(facets.begin(), facets.end());
  return std::size_t(facets.end() - std::unique(facets.begin(), facets.end()));
}

std::size_t bodies(const Mesh& mesh) {
  std::vector<std::uint32_t> root(mesh.vertices.size());
  std::iota(root.begin(), root.end(), 0u);
  const auto find = [&](std::uint32_t v) {
    for (; root[v] != v; v = root[v]) root[v] = root[root[v]];
    return v;
  };
  std::vector<bool> used(root.size());
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) {
      used[v] = true;
      root[find(v)] = find(t[0]);
    }
  std::size_t count = 0;
  for (std::uint32_t v = 0; v < root.size(); ++v) count += used[v] && root[v] == v;
  return count;
}

double twice_area(const Vertex& a, const Vertex& b, const Vertex& c) {
  const double bx = double(b.x) - a.x, by = double(b.y) - a.y, bz = double(b.z) - a.z;
  const double cx = double(c.x) - a.x, cy = double(c.y) - a.y, cz = double(c.z) - a.z;
  const double x = by * cz - bz * cy, y = bz * cx - bx * cz, z = bx * cy - by * cx;
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

MeshCheck check(const Mesh& mesh) {
  MeshCheck out;
  out.vertices = mesh.vertices.size();
  out.facets = mesh.triangles.size();
  count_edges(mesh, out);
  out.duplicate_facets = duplicates(mesh);
  out.bodies = bodies(mesh);
  for (const auto& t : mesh.triangles) {
    const double twice = twice_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
    out.flat_facets += twice == 0.0;
    out.area_mm2 += 0.5 * twice * (kMmPerUnit * kMmPerUnit);
  }
  return out;
}

}  // namespace firn::slice
