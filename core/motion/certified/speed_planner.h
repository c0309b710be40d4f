// SpeedPlanner computes the minimum-time motion along the curve of a segment within the limits of a task, and
// proves it: its ratios to the limits become bounds at every instant.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/motion/certified/path_part.h"
#include "core/motion/certified/stop_segment.h"
#include "core/motion/curve/path_curve.h"
#include "core/motion/time_optimal/motion_bounds.h"
#include "core/motion/time_optimal/speed_bound.h"

namespace firn::motion {

/// Durations from which a motion is of no use.
struct MaxDuration {
  /// The work on a motion ends where it is slower before time scaling. Finer cells might have made it faster.
  double planned_s = kNoMaxDuration_s;
  /// No motion is sought, and the duration is unlimited, where the lower bound along the curve is larger.
  double bound_s = kNoMaxDuration_s;
};

/// Keeps its buffers from segment to segment. A long curve is planned, and proved, window by window
/// (speed_windows.cpp): its buffers are as large as a window.
class SpeedPlanner {
 public:
  /// Sizes of the cells of a curve through the points of `part`.
  static CellSizes cell_sizes(const PathPart& part, const CertifiedTask& task);

  /// Plans along curve.coarse, whose deviation and points `out` has already. Throws MotionError with
  /// Fault::at in the base frame.
  void plan(const PathPart& part, const CellSizes& sizes, const MaxDuration& max, const CertifiedTask& task,
            CurveWork& curve, StopSegment& out);

  /// Makes the ratios of a planned segment bounds at every instant (time_optimal/motion_bounds.h), its factor
  /// with them, and bound_s as sharp as it can be. Does nothing where they are already.
  void prove(const CertifiedTask& task, StopSegment& out);

  /// Work of the solver so far: its steps, each times the cells that it moved.
  std::uint64_t cell_steps() const { return cell_steps_; }

 private:
  struct Effort;
  static Effort effort(const CertifiedTask& task, int attempt);
  void set_rows(const CertifiedTask& task, const StopSegment& out);
  /// Computes the motion of `out` at both ends and inside of every piece, into bounds_.samples.
  void sample(const CertifiedTask& task, int inner, const StopSegment& out);
  /// Sets the ratios of `out` and its factor from these samples.
  void check(const CertifiedTask& task, int inner, StopSegment& out);
  bool plan_straight(const CertifiedTask& task, StopSegment& out);
  /// Returns true if no motion along out.curve takes as little as `max_s`. Overwrites rows_ and bound_.
  bool surely_slower(double max_s, const CertifiedTask& task, const StopSegment& out);
  void solve(const CertifiedTask& task, RowGroups& groups, int active, const Effort& effort,
             StopSegment& out);
  bool solve_active(const CertifiedTask& task, const Effort& effort, bool all, StopSegment& out);
  /// Gives a curve that was planned finer cells where excess_ asks for them.
  using Finer = std::function<void(Curve&)>;
  /// Solves along out.curve, attempt by attempt on finer cells. Returns false where no motion is good.
  bool attempt(const CertifiedTask& task, double max_s, const Finer& finer, StopSegment& out);
  /// Plans along out.curve, which has cells and speed limits. Returns false, and leaves the curve as it is,
  /// where a window has no motion.
  bool plan_windows(const CellSizes& sizes, double max_s, const CertifiedTask& task, StopSegment& out);
  /// Keeps the motion of window_ as far as it is as good as the whole path's, and sets start_ for the next
  /// one. Returns the number of cells kept, 0 = the window is too short.
  std::size_t keep_window(const CertifiedTask& task, const Curve& undivided, bool last, StopSegment& out);
  void prove_windows(const CertifiedTask& task, double sharpness, StopSegment& out);
  void fall_back(const PathPart& part, const CellSizes& sizes, const CertifiedTask& task, CurveWork& curve,
                 StopSegment& out);
  void set_lower_bound(const CertifiedTask& task, StopSegment& out);

  MotionRows rows_;
  SpeedBound bound_;
  ProfileWork solver_;
  Profile profile_;
  BoundWork bounds_;
  std::vector<double> excess_;  ///< factor of time of each cell
  StopSegment trial_;           ///< of a later attempt
  StopSegment window_;          ///< part of a long curve
  ProfileStart start_;          ///< of that part
  bool in_window_ = false;      ///< a part is planned
  std::uint64_t cell_steps_ = 0;
  std::uint64_t sampled_ = 0;  ///< number of the motion that bounds_.samples holds
  std::uint64_t rows_of_ = 0;  ///< and of the one whose curve rows_ and bound_ are of
};

}  // namespace firn::motion
