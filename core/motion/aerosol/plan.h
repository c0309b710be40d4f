// plan_aerosol() computes the motion of a shuttered printer through a job: constant speed where it deposits,
// minimum time where it does not [Thompson 2014, V].
//
// All positions are the nozzle's over the substrate. The stage carries the substrate (II-B) and so moves the
// other way: the sign is taken in one place, sample_stage().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/motion/aerosol/mtt.h"
#include "core/path/print_job.h"

namespace firn::motion {

/// A printer with a continuous flow of material, a shutter and a stage of two equal axes. Defaults: the
/// paper's VI.
struct AerosolMachine {
  AxisLimits axis{4.0, 30.0};
  double shutter_delay_s = 0.0;  ///< from a command to its effect; commands go out so much earlier. No closed
                                 ///< span is shorter than two delays: one to close, one to open.
  double flow_mm3_s = 0.0;       ///< flow of the nozzle, caught by a closed shutter; 0 = not known
  double tick_s = 0.001;         ///< of the trajectory that goes out
  bool substrate_moves = true;   ///< II-B: the stage's motion is minus the path
  Point2 stage_origin;           ///< stage position where the nozzle is over the job's (0, 0)
  Point2 stage_low{-1e9, -1e9};  ///< the stage's range
  Point2 stage_high{1e9, 1e9};
};

enum class CornerMode : std::uint8_t {
  kPaper,   ///< shutter open, speed averaged at the corner (52), (53)
  kLoop,    ///< shutter closed, minimum-time loop; only turns that round within 1 um keep it open
  kHybrid,  ///< rounded at constant speed where that stays within the tolerance, else loop
};
const char* name(CornerMode mode);  ///< "paper", "loop", "hybrid"
inline constexpr std::array<std::string_view, 3> kCornerWords{"paper", "loop", "hybrid"};
constexpr std::span<const std::string_view> words_of(CornerMode) { return kCornerWords; }

struct AerosolOptions {
  CornerMode corner = CornerMode::kLoop;
  double tolerance_mm = 0.05;  ///< hybrid: largest distance of the path from the corner that it rounds
  /// Two speeds along one straight line meet at their mean, with the shutter open; else they loop like
  /// corners.
  bool blend_speeds = false;
};

enum class PieceKind : std::uint8_t { kPrint, kRound, kLoop, kTransit };

/// Constant acceleration on both axes for a while.
struct Piece {
  PieceKind kind = PieceKind::kTransit;
  std::int32_t segment =
      0;  ///< 0-based: the one printed, or the one that the piece leads to (count = to p_end)
  double t_s = 0.0, duration_s = 0.0;
  Point2 p_mm, v_mm_s, a_mm_s2;  ///< at the piece's begin
};

/// Why a segment cannot be printed.
struct Refusal {
  std::int32_t segment = 0;  ///< 0-based
  std::string reason;        ///< with the values and the limit broken
};

/// Where a quantity is largest.
struct Extreme {
  double value = 0.0;
  double t_s = 0.0;
  std::int32_t segment = -1;
};

struct AerosolReport {
  double total_s = 0.0;
  double print_s = 0.0;        ///< shutter open
  double transit_s = 0.0;      ///< shutter closed, from p_start to p_end
  double wasted_mm3 = 0.0;     ///< flow times transit_s
  double lower_bound_s = 0.0;  ///< lengths over speeds, plus each transit's minimum common time
  Extreme speed_error;         ///< |v / v_desired - 1| while the shutter is open
  Extreme
      position_error_mm;  ///< distance to the point that moves along the segment at v_desired, shutter open
  Extreme path_error_mm;  ///< distance to the segments, shutter open
  Extreme axis_speed_ratio, axis_acceleration_ratio;  ///< of the limits, everywhere
  Extreme corner_s;                                   ///< longest loop
  std::int32_t loops = 0, rounded = 0, transits = 0;
};

struct AerosolPlan {
  std::vector<Refusal> refused;   ///< when any: all of them, and nothing else below
  std::vector<Piece> pieces;      ///< in time, without gaps, from rest at p_start to rest at p_end
  std::vector<ShutterSpan> open;  ///< in time
  AerosolReport report;

  bool ok() const { return refused.empty(); }
  double duration_s() const { return pieces.empty() ? 0.0 : pieces.back().t_s + pieces.back().duration_s; }
};

/// @throws MotionError (kLimitNotPositive, kOption) for the machine or the options; a job's faults are
/// refusals.
AerosolPlan plan_aerosol(const PrintJob& job, const AerosolMachine& machine,
                         const AerosolOptions& options = {});

/// The nozzle's position and velocity at a time of the plan.
struct PlaneState {
  Point2 p_mm, v_mm_s;
};
PlaneState state_at(const AerosolPlan& plan, double t_s);

/// The stage's trajectory: axes x, y in mm at the tick, the last sample at rest over p_end; certificate
/// filled. The one place where the sign of a moving substrate is taken: stage = stage_origin - path (+ path
/// when the nozzle moves).
Trajectory sample_stage(const AerosolPlan& plan, const AerosolMachine& machine);

/// Times of the shutter's commands: the effect's times less the delay, opening and closing alternately.
struct ShutterCommand {
  double t_s = 0.0;  ///< may be negative by up to the delay for a job that opens at once
  bool open = false;
};
std::vector<ShutterCommand> shutter_commands(const AerosolPlan& plan, const AerosolMachine& machine);

}  // namespace firn::motion
