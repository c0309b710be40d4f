// recognise() computes lines and arcs from the points of a path. A path arrives as points (dense samples of
// lines and arcs, or a polygon). Its exact geometry determines where the curvature jumps and therefore how
// fast it may be followed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/motion/curve/constants.h"
#include "core/path/given_curve.h"

namespace firn::motion {

/// A line (curvature 0) or an arc between two places of the path.
struct CurvePiece {
  Point2 start;
  double tx = 1.0, ty = 0.0;  ///< unit tangent at the start
  double curvature = 0.0;     ///< 1/mm, > 0 turns left
  double length_mm = 0.0;
  std::size_t first = 0, last = 0;  ///< points of the path that it covers
  bool chord = false;               ///< a single chord of a polygon, not a recognised run of points
  bool given = false;               ///< a given arc, or a chord between two samples of a given curve

  Point2 at(double s_mm) const;
  /// Unit tangent at s_mm.
  Point2 tangent(double s_mm) const;
};

/// Greedy: from each point the longest run of points on a line or circle (>= 4 or >= 5 points, one less where
/// chance is out of the question; within kRecogniseMm, chords' sagitta <= sagitta_mm), else one chord.
/// Neighbouring pieces that are tangent to each other are joined at their point of tangency, also where no
/// input point lies there (a chord across the joint is dropped).
/// @pre points has no repeated neighbours and at least two entries. Time: O(n log n).
/// Only runs that are long or end abruptly are recognised, as meant ones do: a smooth curve has runs within
/// kRecogniseMm of a circle by chance, wherever its curvature changes little.
void recognise(std::span<const Point2> points, double sagitta_mm, std::vector<CurvePiece>& pieces);

/// The same where some of the points are samples of given curves: an arc is one piece, two where it turns by
/// about half a turn or more; a Bezier curve is chords between its samples; a single chord beside given
/// curves is a line that is meant. @param ramp_mm > 0: the first and last chord of a Bezier curve are parted
/// where exact_spacing_mm() is shorter
void recognise(std::span<const Point2> points, std::span<const GivenCurve> given, double sagitta_mm,
               double ramp_mm, std::vector<CurvePiece>& pieces);

/// True if the pieces have a run of at least eight chords shorter than `longest_mm`: a sampled curve.
bool has_dense_run(std::span<const CurvePiece> pieces, double longest_mm);

/// Length of the cells beside a joint of exact pieces: a C2 spline through a jump of curvature and a turn of
/// the tangent between such cells leaves them by at most about `within_mm`. Never longer than half a ramp.
double exact_spacing_mm(double jump, double turn, double ramp_mm, double within_mm = kExactMm);

/// Indices of the points where the polygon turns by more than the angle whose cosine is given, ends included.
void split_points(std::span<const Point2> points, double cos_split, std::vector<std::size_t>& splits);

}  // namespace firn::motion
