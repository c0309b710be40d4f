// build_paths computes the deposition paths of the part of Fig. 4-15 [Barnett 2012, 4.4], each different one
// once; motion_s computes the time of one way of moving for all of them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "config/machine.h"
#include "core/motion/kinematics/limits.h"
#include "core/motion/kinematics/path_input.h"
#include "core/motion/thesis/test_path.h"
#include "studies/reproduce/barnett/box_print.h"

namespace firn::barnett {

/// The middle of the part in the arm's base frame: Fig. 4-3's well-placed path lies around it.
inline constexpr Point2 kBoxPlace{motion::thesis::kWellPlaced.x_mm + 46.0,
                                  motion::thesis::kWellPlaced.y_mm + 46.0};

/// The three cases of 4.4.
enum class Way { kStraightConstant, kConcentricConstant, kVariable };

struct BuildPath {
  PathKind kind = PathKind::kBoundary;
  bool closed = false;
  std::uint8_t material = 0;
  std::vector<Point2> points;
  double length_mm = 0.0;  ///< with the way back to the first point of a closed one
  std::int64_t count = 0;  ///< number of times in the part: walls are the same in all layers
};

struct BuildPaths {
  std::vector<BuildPath> paths;
  double transit_s =
      0.0;  ///< from the end of each path straight to the start of the next of its layer, from rest to rest
  double run_up_s = 0.0;    ///< additional time where straight fill is laid at its whole speed only (3.5):
                            ///< ramps beside its ends, and the way between those
  double volume_mm3 = 0.0;  ///< of all beads
  std::int64_t layers = 0;
  std::int64_t count() const;
  double length_mm() const;
};

/// Paths shorter than the thesis's sampling (0.4 mm) are left out. @param limits of the ways between paths;
/// @param overrides of slicing settings
BuildPaths build_paths(const BoxFolder& folder, const motion::RateLimits& limits,
                       const std::vector<std::string>& overrides, int threads);

/// Returns the minimum time of a straight way from rest to rest (seven phases of constant jerk). @param
/// limits finite, such that the whole acceleration is reached below the speed: acceleration^2 <= rate jerk
double rest_to_rest_s(double distance_mm, const motion::RateLimits& limits);

/// Returns the time of all paths; each different path is planned once. @param duration_s of one path
double motion_s(const BuildPaths& of, const std::function<double(const motion::PathInput&)>& duration_s);

/// Returns the time by the thesis's method or that of constant speed, in whole ticks.
double duration_s(Way way, const motion::PathInput& in, const motion::Arm& arm,
                  const motion::MotionLimits& limits);

}  // namespace firn::barnett
