// SegmentCurve holds the geometry of a segment as it is planned: the curve of one shape through or beside its
// points.
#pragma once

#include <span>
#include <vector>

#include "core/motion/certified/deviation_limits.h"
#include "core/motion/certified/path_part.h"
#include "core/motion/curve/given_curves.h"
#include "core/motion/curve/path_curve.h"
#include "core/motion/curve/tube_fit.h"

namespace firn::motion {

/// Kind of curve through or beside the points.
enum class Shape {
  kPlain,   ///< lines and arcs through the points, without use of the tolerance
  kRamped,  ///< the same with longer ramps of curvature and rounder corners, as the tolerance allows
  kFitted   ///< the spline of least third derivative inside the tube about the polyline
};

/// Keeps its buffers from segment to segment.
class SegmentCurve {
 public:
  /// Builds the curve of `shape`, nearer to the points try by try until it is within its allowed deviation,
  /// or the nearest one that was tried, and sets the distances of `out`. Returns false for a tube that is too
  /// narrow for its turns: another shape holds the points.
  bool build(const PathPart& part, Shape shape, const CellSizes& sizes, const PlanOptions& options,
             StopSegment& out);

  /// Sets the path that deviations are measured from: `part` with its given curves.
  void follow(const PathPart& part);
  /// Sets the distances of the present curve from the followed path and from held points.
  void measure(std::span<const Point2> points, const PlanOptions& options, StopSegment& out) const;
  const GivenReference& followed() const { return followed_; }

  /// The present curve is the fit inside this tube.
  void fit(std::span<const Point2> points, const TubeOptions& tube);

  CurveWork curve;  ///< curve.coarse is the present curve
  TubeWork tube;    ///< of the last fit

 private:
  std::vector<Point2> samples_;  ///< of given curves
  GivenReference followed_;
};

}  // namespace firn::motion
