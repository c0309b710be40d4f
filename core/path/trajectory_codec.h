// Reads and writes trajectories as bytes, for files and messages. Format: docs/formats.md; version
// 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/path/bytes.h"
#include "core/path/path.h"

namespace firn {

using TrajectoryFormatError = FormatError;

inline constexpr std::uint32_t kTrajectoryVersion = 1;

/// The common properties of all trajectories of a file.
struct TrajectoryHead {
  std::string machine;  ///< machine.name of its file
  std::string method;   ///< of the planner
  std::string made_by;  ///< program and commit
  double tick_s = 0.0;
  Point2 origin;                        ///< of the part's frame in the machine's
  std::vector<std::string> axis_names;  ///< "J1", …
  std::vector<std::string> axis_units;  ///< "rad" or "mm"
  bool operator==(const TrajectoryHead&) const = default;
};

/// One path's trajectory with the purpose of the path. trajectory.id is the path's number in its file, from
/// 1.
struct PlannedPath {
  std::int32_t layer = 0;
  std::uint8_t material = 0;
  PathKind kind = PathKind::kFill;
  double path_mm = 0.0;   ///< length
  Trajectory trajectory;  ///< axis_units and tick_s as in the head; not written again
};

/// The end record of a complete file.
struct TrajectoryTotals {
  std::int64_t paths = 0;
  std::int64_t samples = 0;
  double duration_s = 0.0;
  bool operator==(const TrajectoryTotals&) const = default;
};

std::vector<std::byte> encode(const TrajectoryHead& head);
std::vector<std::byte> encode(const TrajectoryTotals& totals);
/// An axis that never moves is written once. Positions are written as they are: reading back gives equal
/// bits.
/// @throws std::invalid_argument: positions that are not whole samples of the axes
std::vector<std::byte> encode(const PlannedPath& path);

// Take any bytes. @throws TrajectoryFormatError: a version or kind unknown, a count above its limit (8 axes,
// 64 limits, 16 million samples, texts of 200 bytes), a number that is not finite, bytes missing or left
// over.
TrajectoryHead decode_trajectory_head(std::span<const std::byte> bytes);
PlannedPath decode_trajectory(std::span<const std::byte> bytes, const TrajectoryHead& head);
TrajectoryTotals decode_trajectory_totals(std::span<const std::byte> bytes);

}  // namespace firn
