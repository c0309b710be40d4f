// FacetView refers to triangles as files hold them: floating point, not owned and not validated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>

namespace firn::slice {

using Corner = std::array<float, 3>;  ///< x, y, z in the file's unit; may be NaN or infinite

/// Either indexed triangles, or a soup in which each facet carries its corners (STL), read in place.
struct FacetView {
  std::span<const Corner> vertices;                         ///< of indexed triangles
  std::span<const std::array<std::uint32_t, 3>> triangles;  ///< each index is below vertices.size()
  const std::byte* soup = nullptr;  ///< first facet: three corners, little endian, at any alignment
  std::size_t stride = 0;           ///< bytes from one facet to the next: 50 in binary STL, 36 packed
  std::size_t soup_facets = 0;
  std::array<double, 3> origin{};  ///< to be added to every corner
  /// Called repeatedly when facets [first, end) of a soup have been read; `follows`: another pass will read
  /// them from the last to the first (the bounding box takes one pass, slicing another). Pages of a mapped
  /// file can then be released. May be empty.
  std::function<void(std::size_t first, std::size_t end, bool follows)> done_with;

  bool indexed() const { return soup == nullptr; }
  std::size_t size() const { return indexed() ? triangles.size() : soup_facets; }
  std::array<Corner, 3> facet(std::size_t n) const {
    std::array<Corner, 3> corners;
    if (indexed())
      for (std::size_t c = 0; c < 3; ++c) corners[c] = vertices[triangles[n][c]];
    else
      std::memcpy(corners.data(), soup + n * stride, sizeof corners);
    return corners;
  }
};

}  // namespace firn::slice
