// plan_certified() computes the motions of methods `certified` and `optimal`: for each segment between stops
// the minimum-time motion within all limits on its curve, checked densely and scaled in time until no limit
// is exceeded.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "core/motion/curve/dense_smoothing.h"
#include "core/motion/curve/given_curves.h"
#include "core/motion/curve/tube_fit.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/time_optimal/motion_bounds.h"
#include "core/motion/time_optimal/motion_samples.h"
#include "core/motion/time_optimal/speed_bound.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// One motion between two stops.
struct StopSegment {
  Curve curve;
  TimedMotion motion;
  RatioTable ratios;                ///< of `motion`, not scaled
  double factor = 1.0;              ///< the motion runs at time / factor
  double bound_s = 0.0;             ///< lower bound of its duration
  TimeGradient gradient;            ///< filled where the curve may be improved
  std::uint64_t sampled = 0;        ///< CertifiedWork::sampled when `motion` was
  bool proved = false;              ///< the ratios are bounds at every instant
  bool closed_form = false;         ///< `motion` is the minimum-time motion within the tool's limits
  double deviation_mm = 0.0;        ///< bound of the Frechet distance from the points (curve/frechet.h)
  double points_off_mm = 0.0;       ///< farthest_point_mm(), where points are held
  std::size_t first = 0, last = 0;  ///< input points where it starts and ends

  /// Unlimited, as deviation_mm then is, where no motion along this curve was found.
  double duration_s() const { return factor * motion.duration_s(); }
};

/// No motion along this curve is wanted.
inline void give_up(StopSegment& segment) {
  segment.motion.t.assign({0.0, kUnlimited});
  segment.factor = 1.0;
}

/// Everything that one planner thread reuses from path to path.
struct CertifiedWork {
  CurveWork curve;
  MotionRows rows;
  SpeedBound bound;
  ProfileWork solver;
  Profile profile;
  StateBatch batch;  ///< at the tick
  Jets tool, joint, flange;
  std::vector<StopSegment> segments, candidate;
  StopSegment trial, corner_trial;
  TimedMotion straight;
  std::vector<std::size_t> stops;
  std::vector<double> length, excess;
  SmoothingWork smoothing;
  std::vector<Point2> smoothed;  ///< points of a segment
  std::vector<GivenCurve> given;
  std::vector<Point2> reference;  ///< sample_given()
  TubeWork tube;
  std::vector<StretchBeyond> beyond;  ///< of a curve that left the tolerance
  bool descends = false;              ///< the curve is being moved: finer cells, and the time's gradient
  std::vector<double> weight;         ///< of a step
  StopSegment shape_trial, other_shape;
  BoundWork bounds;
  std::uint64_t sampled = 0;  ///< number of the motion that work.bounds.samples holds
  std::uint64_t rows_of = 0;  ///< and of the one whose curve work.rows and work.bound are of
};

/// Input that all segments of a path share.
struct CertifiedTask {
  const Arm& arm;
  const MotionLimits& limits;
  const PlanOptions& options;
  Placement placement;
  int joints = 0;
  RowGroups groups;
};

/// Kind of curve through or beside the points.
enum class Shape {
  kPlain,     ///< without use of the tolerance (CurveRule::kRamped only)
  kRamped,    ///< longer ramps of curvature, rounder corners
  kSmoothed,  ///< and the points of dense runs may move (CurveRule::kRamped only)
  kFitted     ///< a spline of least third derivative inside the tube about the polyline
};

/// Plans points (base frame) between two rests. Throws MotionError with Fault::at in the base frame.
/// @param speed_limit one per segment; @param yaw_rad one per point, empty = constant
/// @param given curves among the points; @param most_s a motion that is slower than this before time scaling
/// is abandoned
void plan_segment(std::span<const Point2> points, std::span<const double> speed_limit,
                  std::span<const double> yaw_rad, std::span<const GivenCurve> given, Shape shape,
                  double most_s, const CertifiedTask& task, CertifiedWork& work, StopSegment& out);

/// True unless the speed profile was given up: its motion is slowed down by far. So it is beside a cusp.
inline bool solved(const StopSegment& segment) {
  constexpr double kMostFactor = 1.5;
  return segment.factor < kMostFactor;
}

/// True if the curve may leave the points for the sake of a shorter time.
inline bool within_tolerance(const PlanOptions& options) {
  return options.curve_rule == CurveRule::kFitted && options.tolerance_mm > 0.0 && options.slack == 0.0;
}

/// Maximum deviation of a curve from its path by ramps, rounded corners and vertices: tolerance + w / 2
/// + the chords' sagitta.
double farthest_mm(const PlanOptions& options);

/// Radius of the tube about the points: the tolerance, or the distance by which rounding of both coordinates
/// moves a point.
inline double fit_radius_mm(const PlanOptions& options) {
  constexpr double kDiagonal = 1.4142135623730951;
  return options.tolerance_mm > 0.0 ? options.tolerance_mm : kDiagonal * options.point_noise_mm;
}

/// Distance within which the curve passes every point; 0 = points are not held.
inline double hold_mm(const PlanOptions& options) {
  if (options.point_rule != PointRule::kHeld || options.tolerance_mm > 0.0 ||
      options.curve_rule == CurveRule::kRamped)
    return 0.0;
  return std::max(fit_radius_mm(options), PlanOptions::kLeastHold_mm);
}

inline constexpr double kHoldRadius = 0.99;  ///< of that, for a fitted curve

/// Largest distance between a curve and the polygon of its samples, where these are far apart: a share of
/// what keep_near() takes.
inline double most_between_mm(const PlanOptions& options) {
  constexpr double kShare = 0.9;
  return kShare * farthest_mm(options);
}

/// True where no points are held that the curve leaves.
inline bool holds(const StopSegment& segment, const PlanOptions& options) {
  const double within = hold_mm(options);
  return !(within > 0.0) || segment.points_off_mm <= within;
}

/// Sizes of the cells of a curve through `points`.
CellSizes cell_sizes(std::span<const Point2> points, std::span<const double> speed_limit,
                     std::span<const double> yaw_rad, const CertifiedTask& task, const CertifiedWork& work);

/// Plans along work.curve.coarse, whose deviation and points `out` has already; otherwise as plan_segment.
void plan_curve(std::span<const Point2> points, std::span<const double> speed_limit,
                std::span<const double> yaw_rad, const CellSizes& sizes, double most_s,
                const CertifiedTask& task, CertifiedWork& work, StopSegment& out);

/// Plans along a spline fitted inside the tolerance, or inside the points' rounding, which descent of the
/// time moves there as long as that is faster. out.first and out.last are set.
void plan_fitted(std::span<const Point2> points, std::span<const double> speed_limit,
                 std::span<const GivenCurve> given, const CertifiedTask& task, CertifiedWork& work,
                 StopSegment& out);

/// Splits a path and plans all its segments into work.segments[0 .. result - 1]; with a tolerance, corners
/// are rolled where that is faster.
std::size_t plan_segments(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work);

/// Makes the ratios of a planned segment bounds at every instant (time_optimal/motion_bounds.h), its factor
/// with them, and bound_s as sharp as it can be. Nothing happens where they are already.
void prove(const CertifiedTask& task, CertifiedWork& work, StopSegment& out);

/// Throws MotionError (kPathDeviation: value and bound in mm, index that of the clean path) for a curve that
/// is further off. It gets no certificate.
void keep_near(const StopSegment& segment, const PlanOptions& options);

/// Plans a whole path: samples at the tick, certificate, trace.
PlanResult plan_certified(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                          const PlanOptions& options, CertifiedWork& work);

}  // namespace firn::motion
