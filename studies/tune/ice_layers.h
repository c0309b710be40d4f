// IceLayers holds the observations of an ice print in the form in which those of droplets are kept, so that
// one set of features describes both: an interval counts as a layer, and a hundredth of the commanded growth
// of a nominal interval as a droplet.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "core/slice/paths/print_paths.h"
#include "estimators/droplet/identification.h"

namespace firn::tune {

class IceLayers {
 public:
  /// @param paths the print's input of this role
  /// @throws FormatError: bytes that are no paths
  IceLayers(const Experiment& experiment, std::span<const std::byte> paths);

  /// Adds HEIGHT_MAP and CONTROL_SURFACE; other messages are ignored. Maps of which too little was measured
  /// do not count.
  void take(std::string_view channel, std::span<const std::byte> message);

  /// Cells that every interval judges (replay::judged_cells), on the grid of the first one.
  const Mask& mask() const { return mask_; }
  HeightMap target() const;  ///< the last interval's nominal height
  double noise_std_mm() const;
  /// Intervals one after the other from the table on: the growth that u of the map before commanded, that map
  /// and the next. An interval without its map ends the list.
  std::vector<droplet::PrintedLayer> printed() const;

 private:
  struct Interval {
    int layer = 0;
    double nominal_mm = 0.0;
  };
  struct Map {
    std::int64_t id = 0;
    double noise_mm = 0.0;
    HeightMap height;  ///< on the mask's grid
  };

  double min_measured_;
  std::vector<Interval> intervals_;
  Mask mask_;
  std::map<int, Map> maps_;                   ///< by layer, the newest
  std::map<std::int64_t, HeightMap> action_;  ///< u, by the map that it answers
};

}  // namespace firn::tune
