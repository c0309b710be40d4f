// fill_lines() and fill_zigzag() compute parallel lines across a region: ZZFILL, zigzags and the scan lines
// of the laser [Barnett, 3.5].
#pragma once

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::slice {

/// Returns the unit vector at an angle, rounded to 2^-30, so that it is identical on all machines.
geometry::Vec direction_at(double angle_rad);

/// Returns the parts inside `region` of the lines at integer multiples of the spacing from the origin, as
/// open lines of two points.
geometry::Rings fill_lines(const geometry::Region& region, double spacing_mm, double angle_rad);

/// Returns the same lines, linked along the outline where it leads from one to the next without meeting
/// another line: on one side behind even lines, on the other behind odd ones.
geometry::Rings fill_zigzag(const geometry::Region& region, double spacing_mm, double angle_rad);

/// Returns the area within `half` of open lines; their round ends are approximated from inside.
geometry::Region swept_by(const geometry::Rings& lines, double half_mm);

}  // namespace firn::slice
