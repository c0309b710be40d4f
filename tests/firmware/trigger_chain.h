// trigger_chain() measures how a print's arm, valves and laser kept together, from the world's record: the
// robot's signal starts all three, each then goes by its own clock.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "plant/config/ice_config.h"

namespace firn::test {

/// Holds one path of an instrument that the robot's signal has started. An instrument is late by so much
/// against the arm's true place on its path.
struct ChainPath {
  std::int64_t path = 0;
  double span_s = 0.0;    ///< of the arm's motion
  double begin_ms = 0.0;  ///< late at the path's begin
  double end_ms = 0.0;    ///< late at its end
};

struct ChainPart {
  std::string name;
  std::vector<ChainPath> paths;
  double mean_ms = 0.0;    ///< the part that a calibrated latency takes away
  double worst_ms = 0.0;   ///< the farthest from the mean, at the begin or the end of any path
  double drift_ppm = 0.0;  ///< least squares of end - begin against the span
};

/// Returns valve_a, valve_b and laser_point, of which each has at least one path.
/// @param run folder of a print whose every path was run once, in one piece
/// @param arm, laser as the print's world had them
std::vector<ChainPart> trigger_chain(const std::filesystem::path& run, const plant::IceArmParams& arm,
                                     const plant::IceLaserParams& laser);

}  // namespace firn::test
