#include <bit>

#include "core/slice/mesh/facet_chunks.h"
#include "core/slice/mesh/snap.h"

namespace firn::slice {
namespace {

/// Numbers grid points in the order of their insertion: open addressing, doubled when half full.
class PointTable {
 public:
  explicit PointTable(std::size_t expected) : slots_(std::bit_ceil(2 * expected + 16), 0) {}

  std::uint32_t number(const Vertex& v, std::vector<Vertex>& vertices) {
    if (2 * vertices.size() >= slots_.size()) grow(vertices);
    std::size_t slot = place(v);
    for (; slots_[slot]; slot = (slot + 1) & (slots_.size() - 1))
      if (vertices[slots_[slot] - 1] == v) return slots_[slot] - 1;
    vertices.push_back(v);
    slots_[slot] = std::uint32_t(vertices.size());
    return slots_[slot] - 1;
  }

 private:
  std::size_t place(const Vertex& v) const {
    std::uint64_t h = std::uint64_t(std::uint32_t(v.x)) * 0x9e3779b97f4a7c15ull +
                      std::uint64_t(std::uint32_t(v.y)) * 0xc2b2ae3d27d4eb4full +
                      std::uint64_t(std::uint32_t(v.z)) * 0x165667b19e3779f9ull;
    h ^= h >> 32;
    h *= 0xd6e8feb86659fd93ull;
    return std::size_t(h >> 20) & (slots_.size() - 1);
  }
  void grow(const std::vector<Vertex>& vertices) {
    slots_.assign(2 * slots_.size(), 0);
    for (std::size_t n = 0; n < vertices.size(); ++n) {
      std::size_t slot = place(vertices[n]);
      while (slots_[slot]) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = std::uint32_t(n + 1);
    }
  }
  std::vector<std::uint32_t> slots_;
};

}  // namespace

Mesh weld(const FacetView& facets, const Affine& affine) {
  Mesh mesh;
  mesh.triangles.reserve(facets.size());
  PointTable table(facets.size() / 2);
  for (std::size_t n = 0; n < facets.size(); ++n) {
    const std::array<Corner, 3> f = facets.facet(n);
    if (!finite(f)) continue;
    const std::array<Vertex, 3> v = {to_grid(affine, f[0]), to_grid(affine, f[affine.mirrors ? 2 : 1]),
                                     to_grid(affine, f[affine.mirrors ? 1 : 2])};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
    std::array<std::uint32_t, 3> t{};
    for (std::size_t c = 0; c < 3; ++c) t[c] = table.number(v[c], mesh.vertices);
    mesh.triangles.push_back(t);
    constexpr std::size_t kWave = kChunkFacets * kWaveChunks;
    if (facets.done_with && (n + 1) % kWave == 0) facets.done_with(n + 1 - kWave, n + 1, false);
  }
  return mesh;
}

}  // namespace firn::slice
