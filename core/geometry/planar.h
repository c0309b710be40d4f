// Areas between rings on the integer grid: exact tests, and unions that are right for any input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/region.h"

namespace firn::slice {

/// Twice the signed area in units^2; counter-clockwise is positive.
std::int64_t twice_area(std::span<const Point> ring);
double area_mm2(const Rings& rings);  ///< sum of signed areas

/// Two edges of `rings` that cross, touch or overlap, or a point used twice: the first found, none if the
/// rings are simple and apart. Expected linear time.
struct Contact {
  std::size_t ring_a = 0, ring_b = 0;
  Point at;
};
std::optional<Contact> first_contact(const Rings& rings);
bool simple_and_apart(const Rings& rings);

/// The area where the winding number of directed rings is positive, as a Region; any input, however tangled.
/// Rings that are simple and apart pass untouched in shape; others are cut at their crossings, which are
/// rounded to the grid by snap rounding [Hobby 1999], so that what comes out crosses nowhere (rings may meet
/// in single points). The result depends on the set of rings only, not on their order. @param contact if
/// given, is told where the rings met.
Region region_of(const Rings& directed, std::optional<Contact>* contact = nullptr);

/// Booleans of Regions (or directed rings: winding number positive), by the same exact overlay.
Region unite(const Rings& a, const Rings& b);
Region subtract(const Rings& a, const Rings& b);
Region common(const Rings& a, const Rings& b);

/// Begin each ring at its smallest point, leave out repeated points and rings of fewer than three, sort the
/// rings.
Rings canonical(const Rings& rings);

/// Winding number of directed rings round a point; a point on a ring counts as just right of and above
/// itself.
int winding(const Rings& rings, Point at);

/// Which ring of a Region lies in which.
struct Nest {
  std::int32_t parent = -1;  ///< smallest ring around; -1 = none
  std::int32_t depth = 0;    ///< 0 = outermost; even = outer, odd = hole in a Region
};
std::vector<Nest> nesting(const Rings& region);

}  // namespace firn::slice
