// edge_width_mm() and corner_radius_mm() compute the shape of a part's edge from a surface over its outline.
#pragma once

#include "core/grid/grid.h"

namespace firn {

/// Returns the mean width of the edge from 10 to 90 % of the target's height: the area of ground on which
/// the surface lies between the two, over the length of the contour at half height (both by linear
/// interpolation over the triangles between four cells and their mean). Beyond the outline the height of the
/// nearest cell of the part counts as the target's. A step from one cell to the next reads 0.8 pitches.
/// NaN: less than a quarter of the part has reached 90 %. @pre the three are of one grid
double edge_width_mm(const HeightMap& height, const HeightMap& target, const Mask& mask);

/// Returns the mean radius at half height of the outline's convex right-angled corners between two straight
/// sides of at least six cells: a rounded corner passes its sharp one at (sqrt(2) - 1) radii along the
/// bisector. The sharp corner is the crossing of the surface's own sides, so that a part that is too wide
/// has no other radius. A step from one cell to the next reads 0.7 pitches. NaN: no such corner, or none
/// that reaches half height. @pre as above
/// @param parts of the map's cells along a side of a cell of the outline, which is a staircase for finer maps
double corner_radius_mm(const HeightMap& height, const HeightMap& target, const Mask& mask, int parts = 1);

}  // namespace firn
