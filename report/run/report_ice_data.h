// What a report needs of a run of the ice lab, beside what it needs of any.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/grid/grid.h"
#include "core/slice/paths/print_paths.h"
#include "replay/run_messages.h"

namespace firn::replay {

/// One measured interval. `height` and `truth` are on the interval's own grid, `truth` as means of the
/// simulated field.
struct IceInterval {
  int layer = 0;
  double nominal_mm = 0.0;
  HeightMap height;
  std::optional<HeightMap> truth;
  Mask footprint;                   ///< judged_cells()
  double saturated_fraction = 0.0;  ///< of the action that answered it
};

/// One path as it was planned: speed of the tool and frequency of the valve along it [Barnett 2012, Figs.
/// 6-2, 6-3].
struct IcePathCurve {
  std::int64_t path = 0;
  int layer = 0;
  std::vector<double> time_s, speed_mm_s;
  std::vector<double> pulse_s, frequency_hz;  ///< between pulses
};

struct IceData {
  std::vector<IceInterval> intervals;
  std::optional<HeightMap> field;     ///< the part as built, on the simulation's cells
  std::optional<IcePathCurve> curve;  ///< of the highest layer's longest part path of at most 8 s
};

/// Means of the field over the cells of `grid`; NaN where it has none.
HeightMap cell_means(const HeightMap& field, const GridSpec& grid);

/// Where a layer is judged: its footprint with all spots between beads (up to kWidestSpot_mm wide; the slicer
/// leaves none wider than 1.45 mm), less the cells at its border, which reach beyond the beads over bare
/// table. What remains begins 1 to 2 mm inside the outer edge (at cells of 1 mm), where the outermost
/// measurement path runs [5.2.1].
Mask judged_cells(const slice::LayerPaths& layer, const GridSpec& grid);
inline constexpr double kWidestSpot_mm = 2.0;

/// Of the true surface about the nominal height, over the judged cells of `layer`, on cells of `pitch_mm`.
ErrorStats ice_error(const HeightMap& field, const slice::LayerPaths& layer, double pitch_mm);

/// @throws FormatError, std::invalid_argument: inputs that are no paths; logfile::FileError
IceData read_ice_data(const std::filesystem::path& run, const RunMessages& messages,
                      std::span<const std::byte> paths);

}  // namespace firn::replay
