// Computes exact predicates, unions and differences of areas between rings on the integer grid, for any
// input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::geometry {

/// Returns twice the signed area in units^2; counter-clockwise is positive.
std::int64_t twice_area(std::span<const Point> ring);
double area_mm2(const Rings& rings);  ///< sum of signed areas

/// A pair of edges that cross, touch or overlap, or a point that is used twice.
struct Contact {
  std::size_t ring_a = 0, ring_b = 0;
  Point at;
};
/// Returns a contact of `rings`, or nothing if they are simple and disjoint. Of several contacts the one in
/// the lowest row, and there in the leftmost cell, of a raster with four cells per edge is reported. Expected
/// time n log n.
std::optional<Contact> first_contact(const Rings& rings);

/// Returns the area where the winding number of directed rings is positive, for any input. Rings that are
/// simple and disjoint keep their points; others are divided at their crossings, which snap rounding moves to
/// the grid [Hobby 1999], so that the result has no crossings (rings may touch in single points). The result
/// depends on the set of rings and not on their order. @param contact if given, receives the first contact
Region region_of(const Rings& directed, std::optional<Contact>* contact = nullptr);

/// Return the union, difference and intersection of Regions (or of directed rings: winding number positive)
/// by the same exact overlay.
Region unite(const Rings& a, const Rings& b);
Region subtract(const Rings& a, const Rings& b);
Region common(const Rings& a, const Rings& b);

/// Returns the rings in canonical form: each begins at its smallest point, repeated points and rings of fewer
/// than three points are left out, and the rings are sorted.
Rings canonical(const Rings& rings);

/// Returns the winding number of directed rings about a point. A point on a ring counts as just right of and
/// above itself.
int winding(const Rings& rings, Point at);

}  // namespace firn::geometry
