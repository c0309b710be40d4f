// Rings holds closed curves on the integer grid in two arrays; all stages of the slicer exchange it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace firn::geometry {

/// Coordinates are multiples of 0.1 um: 32 bits hold 214 m, and products of differences of 400 m fit 64 bits
/// twice over.
inline constexpr std::int32_t kUnitsPerMm = 10'000;
inline constexpr double kMmPerUnit = 1.0 / kUnitsPerMm;

struct Point {
  std::int32_t x = 0, y = 0;
  bool operator==(const Point&) const = default;
  auto operator<=>(const Point&) const = default;
};

/// Any number of rings (the last point joins the first, which is not repeated) or of open polylines.
struct Rings {
  std::vector<Point> points;        ///< of all rings, one after the other
  std::vector<std::uint32_t> ends;  ///< ends[r] = index behind the last point of ring r

  std::size_t size() const { return ends.size(); }
  bool empty() const { return ends.empty(); }
  std::span<const Point> operator[](std::size_t ring) const {
    const std::size_t begin = ring ? ends[ring - 1] : 0;
    return {points.data() + begin, ends[ring] - begin};
  }
  void add(std::span<const Point> ring) {
    points.insert(points.end(), ring.begin(), ring.end());
    ends.push_back(std::uint32_t(points.size()));
  }
  void clear() {
    points.clear();
    ends.clear();
  }
  bool operator==(const Rings&) const = default;
};

/// Rings that bound an area: none crosses itself or another one, outer rings run counter-clockwise and holes
/// clockwise, so that the area lies left of each. In canonical form each ring begins at its smallest point,
/// and the rings are sorted by it.
using Region = Rings;

}  // namespace firn::geometry
