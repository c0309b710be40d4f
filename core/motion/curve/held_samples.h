// Computes from held points, samples of a curve that are rounded, how that curve runs between them.
#pragma once

#include <span>
#include <vector>

#include "core/path/path.h"

namespace firn::motion {

inline constexpr double kMostSampledTurn = 0.8;  ///< of samples' chords; what turns more is a corner

/// Angle by which b-c turns from a-b, -pi to pi.
double turn_at(Point2 a, Point2 b, Point2 c);

/// Lengths along held points [mm], in the direction of the points about each step: one against that or aside
/// is rounding, or an overlap of two chords. @param radius within which the curve passes the points
void held_lengths(std::span<const Point2> line, double radius, std::vector<double>& length);

/// True where a chord is so much longer than one beside it that it is no sample interval but a line, unless
/// it is short enough to be one of a curve sampled unevenly: it is not so long beside the other one, or the
/// points beyond an end bend like that curve.
bool is_line(std::span<const Point2> line, const std::vector<double>& length, std::size_t chord);

/// Distance within which a curve passes between two of its samples: some of it beyond the sagitta of the arcs
/// that turn at both ends of the chord as the polygon does: the mean of both, or the smaller one beside a
/// line.
double bulge_mm(std::span<const Point2> line, std::size_t chord, double most_mm);

}  // namespace firn::motion
