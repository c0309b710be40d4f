// Parallel lines across a region: ZZFILL, zigzags and the laser's scan lines [Barnett, 3.5].
#pragma once

#include "core/geometry/region.h"
#include "core/geometry/vec.h"

namespace firn::slice {

/// Unit vector at an angle, rounded to 2^-30, so that it is the same on every machine.
Vec direction_at(double angle_rad);

/// Stretches inside `region` of the lines at whole multiples of the spacing from the origin, as open lines of
/// two points.
Rings fill_lines(const Region& region, double spacing_mm, double angle_rad);

/// The same lines, linked along the outline where the outline leads from one to the next without meeting
/// another: at one side behind even lines, at the other behind odd ones.
Rings fill_zigzag(const Region& region, double spacing_mm, double angle_rad);

/// The area within `half` of open lines, its round ends drawn from inside.
Region swept_by(const Rings& lines, double half_mm);

}  // namespace firn::slice
