// Methods `certified` and `optimal`: stretches between stops, each the fastest motion within all limits on
// its curve, checked densely and stretched in time until no limit is exceeded.
#pragma once

#include <span>
#include <vector>

#include "core/motion/curve/dense_smoothing.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/time_optimal/motion_samples.h"
#include "core/motion/time_optimal/speed_bound.h"
#include "core/motion/trajectory/plan.h"

namespace firn::motion {

/// One motion between two stops.
struct Stretch {
  Curve curve;
  TimedMotion motion;
  RatioTable ratios;     ///< of `motion` as it stands
  double factor = 1.0;   ///< the motion runs at time / factor
  double bound_s = 0.0;  ///< lower bound of its duration
  double deviation_mm = 0.0;
  std::size_t first = 0, last = 0;  ///< input points where it starts and ends

  double duration_s() const { return factor * motion.duration_s(); }
};

/// Everything that one planner thread reuses from path to path.
struct CertifiedWork {
  CurveWork curve;
  MotionRows rows;
  SpeedBound bound;
  ProfileWork solver;
  Profile profile;
  StateBatch batch;
  Jets tool, joint, flange;
  std::vector<Stretch> stretches, candidate;
  Stretch trial, corner_trial;
  TimedMotion straight;
  std::vector<std::size_t> stops;
  std::vector<double> length, excess;
  SmoothingWork smoothing;
  std::vector<Point2> smoothed;  ///< points of a stretch
  Stretch shape_trial;
};

/// What all stretches of a path share.
struct CertifiedTask {
  const Arm& arm;
  const MotionLimits& limits;
  const PlanOptions& options;
  Placement placement;
  int joints = 0;
  RowGroups groups;
};

/// What the tolerance is used for; without one all are the same.
enum class Shape {
  kPlain,    ///< nothing: the curve as without it
  kRamped,   ///< longer ramps of curvature, rounder corners
  kSmoothed  ///< and the points of dense runs may move
};

/// Plans points (base frame) between two rests. Throws MotionError with Fault::at in the base frame.
/// @param ceiling one per segment; @param yaw_rad one per point, empty = constant
/// @param most_s a motion that is slower than this before it is stretched to keep all limits is not worked on
/// further
void plan_stretch(std::span<const Point2> points, std::span<const double> ceiling,
                  std::span<const double> yaw_rad, Shape shape, double most_s, const CertifiedTask& task,
                  CertifiedWork& work, Stretch& out);

/// Splits a path and plans all its stretches into work.stretches[0 .. result - 1]; with a tolerance, corners
/// are rolled where that is faster.
std::size_t plan_stretches(const CleanPath& path, const CertifiedTask& task, CertifiedWork& work);

/// How far ramps, rounded corners and interpolated vertices may lead a curve off its path: tolerance + w / 2
/// + the chords' sagitta.
double farthest_mm(const PlanOptions& options);

/// Throws MotionError (kAstray: value and bound in mm, index that of the clean path) for a curve that is
/// further off. It gets no certificate.
void keep_near(const Stretch& stretch, const PlanOptions& options);

/// The whole of it: samples at the tick, certificate, trace.
PlanResult plan_certified(const PathInput& input, const Arm& arm, const MotionLimits& limits,
                          const PlanOptions& options, CertifiedWork& work);

}  // namespace firn::motion
