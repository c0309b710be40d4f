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
#include <tuple>
#include <vector>

#include "config/experiment.h"
#include "core/grid/offsets.h"
#include "core/statistics/held_out.h"
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

  /// Adds HEIGHT_MAP, STAGE_COMMAND and, after the commands that they report on, DEPOSITION_REPORT; other
  /// messages are ignored. A later attempt at a layer replaces its map.
  void take(std::string_view channel, std::span<const std::byte> message);

  const Experiment& experiment() const { return experiment_; }
  const Mask& mask() const { return mask_; }
  int layers() const;             ///< with their map and that of the layer before
  double noise_std_mm() const;    ///< mean of the maps, of one cell
  std::int64_t droplets() const;  ///< in these layers
  std::vector<droplet::PrintedLayer> printed() const;
  /// Returns the places of these layers' droplets inside their cells; without cells: all in the centres.
  std::vector<OffsetMap> offsets() const;
  /// Returns the centre of an almost uninformative prior: the experiment's model; or a model of the same form
  /// in the size of the maps' rise per droplet, where that is beyond the prior's own standard deviation. So
  /// records of any scale can be learned from.
  deposition::DropletModel prior() const;
  struct Learned {
    droplet::Estimate all;         ///< after all layers, from prior()
    statistics::HeldOut held_out;  ///< unknown (no cell) for fewer than three layers
  };
  /// Learns from the layers one after the other. The estimate after the first two thirds predicts the others,
  /// each from the maps and droplets before it.
  /// @throws std::invalid_argument: no map of the bare ground, no layer.
  Learned learn() const;
  /// Returns the excitation that a fit would find, about prior(), from eight stretches of layers spread over
  /// the record. Nothing for a record of so few layers that they would be most of it.
  std::optional<double> glance_excitation() const;

 private:
  droplet::EstimatorOptions estimator_options() const;
  deposition::Border border() const;
  statistics::HeldOut predict(const droplet::Estimate& fit, int fitted_layers) const;
  double noise_of(const height_map_t& map) const;  ///< reported, or else that of the other maps
  /// Returns the permitted uses of a layer's map, given the droplets of `drops`.
  std::vector<droplet::Use> use_of(const droplet::LayerDrops& drops, const height_map_t& map) const;

  Experiment experiment_;
  Mask mask_;
  std::map<int, height_map_t> maps_;
  std::map<int, droplet::LayerDrops> drops_;
  std::map<std::tuple<int, int, int>, Placement>
      placed_;  ///< by layer, attempt, pass, of droplets beside centres
  std::map<int, OffsetMap> offsets_;
  mutable std::optional<double> usual_noise_mm_;  ///< of maps that report none; empty: not computed yet
};

}  // namespace firn
