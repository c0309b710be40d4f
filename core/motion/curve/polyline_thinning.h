// thin_polyline() computes a polyline of fewer vertices within a small distance of a dense one, in linear
// time: the vertices of a path that was sampled densely carry rounding, not shape.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/path/path.h"

namespace firn::motion {

/// Greedy: from each kept vertex the last one that a sleeve of half width `within_mm` about the chord reaches
/// past all vertices between [Imai, Iri 1986]; runs do not turn back by more than `within_mm`. The Frechet
/// distance between the two polylines is at most 2 within_mm. Both ends are kept.
/// @param kept ascending indices into `points`. @pre at least two points
void thin_polyline(std::span<const Point2> points, double within_mm, std::vector<std::size_t>& kept);

}  // namespace firn::motion
