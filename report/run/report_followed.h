// Reads and shows the paths that the stage of a print of lines followed, beside the planned ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/path/followed_path.h"
#include "runs/read/run_messages.h"

namespace firn::report {

/// One layer's path as FOLLOWED_PATH recorded and PATH_REPORT judged it.
struct FollowedLayer {
  std::int32_t layer = 0;
  std::vector<Point2> planned;  ///< at the times of the samples
  std::vector<Point2> beside;   ///< how far the stage was from it there, across its direction
  std::vector<double> time_s, contour_um;
  double contour_max_um = 0.0, contour_rms_um = 0.0, following_max_um = 0.0, lag_ms = 0.0, switch_um = 0.0,
         offset_rms_um = 0.0;
};

/// Returns the layers whose path was recorded, in order.
std::vector<FollowedLayer> read_followed(const runs::RunMessages& messages);

struct NamedPaths {
  std::string name;
  const std::vector<FollowedLayer>* layers;
  int style = 0;
};
/// Returns HTML: the last layer's path with its deviations enlarged, the contour error along it, and a table
/// of all layers; empty where none was recorded.
std::string followed_sections(const std::vector<NamedPaths>& runs);

}  // namespace firn::report
