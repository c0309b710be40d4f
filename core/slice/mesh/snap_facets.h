// snap_facets() computes the grid coordinates of facets: nine integers each.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/slice/mesh/facets.h"
#include "core/slice/mesh/snap.h"

namespace firn::slice {

/// Placements that only scale and translate: two numbers at a time.
class Scaling {
 public:
  explicit Scaling(const Affine& a) {
    for (std::size_t i = 0; i < kPairs; ++i)
      for (std::size_t j = 0; j < 2; ++j) {
        factor_[i][j] = a.matrix[4 * ((kFirst[i] + j) % 3)];
        shift_[i][j] = a.shift[(kFirst[i] + j) % 3];
      }
  }
  /// @param corners nine floats, at any alignment
  void operator()(const std::byte* corners, std::int32_t* grid) const {
    Words words[kPairs];
    for (std::size_t i = 0; i < kPairs; ++i) {
      float two[2];
      std::memcpy(two, corners + sizeof(float) * kFirst[i], sizeof two);
      const Pair numbers = {two[0], two[1]};
      words[i] = std::bit_cast<Words>((numbers * factor_[i] + shift_[i]) + kRounding);
    }
    for (std::size_t i = 0; i + 1 < kPairs; i += 2) {
      const Words four = __builtin_shufflevector(words[i], words[i + 1], 0, 2, 4, 6);
      std::memcpy(grid + kFirst[i], &four, sizeof four);
    }
    grid[8] = words[kPairs - 1][2];
  }

 private:
  using Pair = double __attribute__((vector_size(16)));
  using Words = std::int32_t __attribute__((vector_size(16)));
  static constexpr std::size_t kPairs = 5;
  static constexpr std::size_t kFirst[kPairs] = {0, 2, 4, 6, 7};  // nine numbers, one of them read twice
  Pair factor_[kPairs], shift_[kPairs];
};

/// Any placement.
class Turning {
 public:
  explicit Turning(const Affine& a) : affine_(a) {}
  void operator()(const std::byte* corners, std::int32_t* grid) const {
    std::array<Corner, 3> f;
    std::memcpy(f.data(), corners, sizeof f);
    for (std::size_t c = 0; c < 3; ++c) {
      const Vertex v = to_grid(affine_, f[c]);
      const std::int32_t whole[3] = {v.x, v.y, v.z};
      std::memcpy(grid + 3 * c, whole, sizeof whole);
    }
  }

 private:
  const Affine& affine_;
};

/// Snaps facets [first, end), without those that are not finite. @return their number in `grid`
template <class Snap>
std::size_t snap_facets(const FacetView& facets, const Affine& affine, const Snap& snap, std::size_t first,
                        std::size_t end, std::int32_t* grid) {
  const std::int32_t* const begin = grid;
  const auto add = [&](const std::byte* corners) {
    snap(corners, grid);
    grid += 9;
  };
  if (!facets.indexed() && !affine.not_finite) {
    for (std::size_t n = first; n < end; ++n) {
      __builtin_prefetch(facets.soup + n * facets.stride + 2048);
      add(facets.soup + n * facets.stride);
    }
  } else {
    for (std::size_t n = first; n < end; ++n) {
      const std::array<Corner, 3> f = facets.facet(n);
      if (!affine.not_finite || finite(f)) add(reinterpret_cast<const std::byte*>(f.data()));
    }
  }
  const std::size_t count = std::size_t(grid - begin) / 9;
  if (affine.mirrors)
    for (std::int32_t* f = grid - 9 * count; f != grid; f += 9) std::swap_ranges(f + 3, f + 6, f + 6);
  return count;
}

}  // namespace firn::slice
