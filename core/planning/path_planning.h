// Computes of one path of a print the arm's position tick by tick, and when the valve opens [Barnett
// 2012, 5.2.2, 6.2].
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/control/surface/surface_controller.h"
#include "core/deposition/pulses.h"
#include "core/grid/parallel.h"
#include "core/motion/kinematics/arm.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/tool.h"
#include "core/motion/planner.h"
#include "core/slice/paths/print_paths.h"

namespace firn::planning {

/// Nominal speeds of one material: those of u = 0, before the motion limits.
struct MaterialSpeeds {
  double boundary_mm_s = 25.0;  ///< also hooks
  double fill_mm_s = 25.0;
  double measure_mm_s = 50.0;
  double of(PathKind kind) const {
    return kind == PathKind::kMeasurement ? measure_mm_s
           : kind == PathKind::kFill      ? fill_mm_s
                                          : boundary_mm_s;
  }
};

/// A valve as the lab believes it to be.
struct ValveSetup {
  deposition::ValveSetting setting;
  double latency_s = 0.0;  ///< from a pulse's tick to liquid on the surface: pulses come so much earlier
};

/// The arm that follows the paths.
struct PlanningArm {
  std::shared_ptr<const motion::Arm> kinematics;
  motion::MotionLimits limits;
  std::vector<motion::Tool> tools;  ///< by name; a path names one of them
  motion::ArmConfiguration preferred;
  double tick_s = 0.016;      ///< of the trajectories
  double speed_mm_s = 125.0;  ///< maximum speed of a tool
};

struct PlanningSetup {
  PlanningArm arm;
  motion::Tool laser;  ///< as calibrated, its point in the middle of the range
  Point2 origin;       ///< of the part's frame in the arm's [mm]
  double origin_z_mm = 0.0;
  double nozzle_gap_mm = 3.0;  ///< nozzle above the layer's nominal top
  double tolerance_mm = 0.05;  ///< PlanOptions::tolerance_mm
  double coverage_window_mm =
      5.0;  ///< some beads' widths; 0: beads that overlap or leave spots are laid as they are
  double action_step_mm = 2.0;  ///< a path that follows an action of the speed has a point at least so often
  std::array<MaterialSpeeds, 2> speeds;
  std::vector<ValveSetup> valves;  ///< by material
  deposition::ValveLimits valve_limits;
  control::SurfaceVersion version = control::SurfaceVersion::kPathSpeed;
};

/// Task of the planner: a line of a layer, or a piece of it, at the height of the tool in use above the
/// part's origin.
struct PathTask : Path {
  std::string tool;  ///< of the arm; "laser": the setup's
  std::shared_ptr<const HeightMap>
      excess;  ///< coverage of its layer's beads less 1 (core/slice/coverage/footprint.h): less flows where
               ///< they overlap; null: as they are
  bool deposits() const { return kind != PathKind::kMeasurement; }
};

/// One list for the valve's controller.
struct PlannedList {
  double start_s = 0.0;     ///< of the trajectory; the arm rests there
  double volume_mm3 = 0.0;  ///< wanted until the next list
  std::vector<std::int32_t> ticks;
};

struct PlannedTask {
  std::string problem;       ///< why there is none: reason, point, value and limit; the rest is empty then
  Trajectory trajectory;     ///< of all joints
  std::vector<Point2> tool;  ///< in the part's frame, at the ticks
  std::vector<PlannedList> lists;
  double length_mm = 0.0, volume_mm3 = 0.0;
  double clipped_mm3 = 0.0;  ///< wanted beyond what the valve gives, and left out
  std::int64_t pulses() const;
};

/// The paths of a layer that deposit (with their layer's excess), or those that measure it, in their order,
/// without lines shorter than 0.05 mm. A measurement path that takes longer than one list of the robot
/// (max_duration_s of the valves) is divided into equal pieces.
std::vector<PathTask> tasks_of(const slice::PrintPaths& paths, const slice::LayerPaths& layer,
                               bool measurement, const PlanningSetup& setup);

/// Plans any number of tasks; keeps the planner's memory, and the motions of the tasks of the last two
/// batches: a path that is met again in another layer, at the same speed, is not planned again.
class TaskPlanner {
 public:
  /// @throws std::invalid_argument: no arm, fewer valves than two, what deposition::check refuses
  explicit TaskPlanner(PlanningSetup setup);
  ~TaskPlanner();

  /// "" or why the arm cannot follow the task: cheap, without planning it.
  std::string unreachable(const PathTask& task) const;

  /// `action`: U' over the interval's grid, nullptr = none. Both versions lay (1 + u_i) w dh per length: q_i
  /// = (1 + u_i) w dh c_i, frequency h(q_i) (6.2)-(6.6). Speed version: the speed limit at point i is c_i =
  /// c_nom / (1 + u_i) (5.7)-(5.9), so that the flow is the constant w dh c_nom wherever the arm reaches its
  /// speed limit, and falls with the speed where it cannot (ends, corners). Frequency version: the speeds are
  /// nominal. A path whose pulses do not fit one list is given rests. The same for any number of threads.
  std::vector<PlannedTask> plan(std::span<const PathTask> tasks, const HeightMap* action,
                                const ParallelFor& parallel);
  PlannedTask plan(const PathTask& task, const HeightMap* action);

  /// Plans the motions alone, without an action, so that plan() finds them.
  void prepare(std::span<const PathTask> tasks, const ParallelFor& parallel);
  void next_batch();  ///< motions that were not met since the last call but one are forgotten
  std::size_t motions_planned() const;  ///< calls of the motion planner so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A point every `step_mm` of a polygon at least; the original points stay.
std::vector<Point2> subdivided(const std::vector<Point2>& points, bool closed, double step_mm);

}  // namespace firn::planning
