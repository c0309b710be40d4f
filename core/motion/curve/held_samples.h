// Held points are rounded samples of a curve. These functions estimate the curve between them: its length
// parameter at each point, chords that are lines and no sample intervals, and its distance from a chord.
#pragma once

#include <span>
#include <vector>

#include "core/path/path.h"

namespace firn::motion {

/// Angle by which b-c turns from a-b, -pi to pi.
double turn_at(Point2 a, Point2 b, Point2 c);

/// Computes the length parameter of each held point [mm]: the sum of the steps, each projected onto the
/// direction of the points about it. A step back or aside is rounding and adds nothing.
/// @param radius the curve passes each point within this distance [mm]
void held_lengths(std::span<const Point2> line, double radius, std::vector<double>& length);

/// Returns true if a chord is a line and no sample interval: it is at least four times longer than a chord
/// beside it, and longer than 5 mm or not the flat part of a curve that is sampled unevenly. Of such a curve
/// the other neighbour is long, too, or the points beyond an end turn as the curvature there demands.
bool is_line(std::span<const Point2> line, const std::vector<double>& length, std::size_t chord);

/// Returns the maximum distance of the curve from the chord between two samples [mm]: twice the sagitta of
/// the arcs that turn at the chord's ends as the polygon does. The mean of both ends, or the smaller one
/// beside a line; at most `max_mm`.
double bulge_mm(std::span<const Point2> line, std::size_t chord, double max_mm);

}  // namespace firn::motion
