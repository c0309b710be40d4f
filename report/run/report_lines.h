// Reads and shows the lines of a print: cross-section and width along the way, layer by layer, ends, delays
// and flow as identified.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/path/print_job.h"
#include "report/run/report_data.h"
#include "report/run/report_followed.h"
#include "runs/read/run_messages.h"

namespace firn::report {

/// The layer below one LINE_PLAN, as the plan reports it.
struct LineLayer {
  std::int32_t layer = 0;
  std::vector<double> area_um2, layer_area_um2, width_um;  ///< by station, NaN: not read
  std::vector<double> seen_width_um;                       ///< by the camera; empty: there is none
  double gap_um = 0.0;                                     ///< that it saw, of all stations
  double start_error_um = 0.0, end_error_um = 0.0;
  double open_delay_ms = 0.0, close_delay_ms = 0.0;  ///< for the layer after it
  double flow_share = 1.0, sheath_share = 1.0;       ///< the same
};

struct LineData {
  std::vector<LineLayer> layers;  ///< measured ones, from 1
  std::vector<double> way_mm;     ///< of the stations, along the job
  std::vector<FollowedLayer> followed;
};

LineData read_line_data(const runs::RunMessages& messages);

/// The cut across the middle of the longest segment, over its nearest neighbours; none for a job without one.
std::optional<SurfaceCut> line_cut(const PrintJob& job);

struct NamedLines {
  std::string name;
  const LineData* data;
  int style = 0;
};
/// Returns HTML; empty for no run.
std::string line_sections(const std::vector<NamedLines>& runs);

}  // namespace firn::report
