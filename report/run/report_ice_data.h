// IceData holds the data of a run of the ice lab for a report, beside those of any run.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/slice/paths/print_paths.h"
#include "replay/ice_error.h"
#include "runs/read/run_messages.h"

namespace firn::report {

/// Holds one measured interval. `height` and `truth` are on the interval's own grid, `truth` as means of the
/// simulated field.
struct IceInterval {
  int layer = 0;
  double nominal_mm = 0.0;
  HeightMap height;
  std::optional<HeightMap> truth;
  Mask footprint;                   ///< judged_cells()
  double saturated_fraction = 0.0;  ///< of the action that answered it
};

/// Holds one path as it was planned: speed of the tool and frequency of the valve along it [Barnett 2012,
/// Figs. 6-2, 6-3].
struct IcePathCurve {
  std::int64_t path = 0;
  int layer = 0;
  std::vector<double> time_s, speed_mm_s;
  std::vector<double> pulse_s, frequency_hz;  ///< between pulses
};

struct IceData {
  std::vector<IceInterval> intervals;
  std::optional<HeightMap> field;       ///< the part as built, on the simulation's cells
  std::optional<OutlineStats> outline;  ///< of the field: of part and scaffold together
  std::optional<IcePathCurve> curve;    ///< of the highest layer's longest part path of at most 8 s
  replay::NominalPart nominal;          ///< part and scaffold
};

/// Reads the data of a run.
/// @throws FormatError, std::invalid_argument: inputs that are no paths; record::FileError
IceData read_ice_data(const std::filesystem::path& run, const runs::RunMessages& messages,
                      std::span<const std::byte> paths);

}  // namespace firn::report
