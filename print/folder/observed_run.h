// ObservedRun holds the observations of a print: the drops of each layer and the maps between. It reads a run
// folder, or the messages of a print in memory; never the state of the simulated world.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "estimators/droplet/droplet_estimator.h"
#include "estimators/droplet/identification.h"
#include "estimators/droplet/layer_drops.h"
#include "firn/height_map_t.hpp"

namespace firn {

/// @throws UsageError: the run is not of a lab of droplets
void require_droplets(const Experiment& experiment, const std::string& run);

class ObservedRun {
 public:
  ObservedRun(const Experiment& experiment, Mask mask);
  /// Reads the write-ahead files of a run. @throws UsageError: not a run folder; no droplets; two inks; a
  /// configuration that cannot be read.
  static ObservedRun read(const std::filesystem::path& run);

  /// Adds HEIGHT_MAP and DEPOSITION_REPORT; other messages are ignored. A later attempt at a layer replaces
  /// its map.
  void take(std::string_view channel, std::span<const std::byte> message);

  const Experiment& experiment() const { return experiment_; }
  const Mask& mask() const { return mask_; }
  int layers() const;             ///< with their map and that of the layer before
  double noise_std_mm() const;    ///< mean of the maps, of one cell
  std::int64_t droplets() const;  ///< in these layers
  std::vector<droplet::PrintedLayer> printed() const;
  /// Returns the estimate after all layers, from a prior that is almost uninformative.
  /// @throws std::invalid_argument: no map of the bare ground, no layer.
  droplet::Estimate learn() const;

 private:
  /// Returns the permitted uses of a layer's map, given the droplets of `drops`.
  std::vector<droplet::Use> use_of(const droplet::LayerDrops& drops, const height_map_t& map) const;

  Experiment experiment_;
  Mask mask_;
  std::map<int, height_map_t> maps_;
  std::map<int, droplet::LayerDrops> drops_;
};

}  // namespace firn
