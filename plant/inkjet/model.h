// Model computes the simulated nature of the ink-jet lab: landing of droplets, curing by the lamp, the
// sensor's surface and the truth.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material_columns.h"
#include "plant/config/world_config.h"
#include "plant/inkjet/field.h"
#include "plant/inkjet/validity.h"
#include "plant/record/archive.h"

namespace firn::plant {

/// Holds position and speed of the stage at the jet's trigger.
struct Shot {
  std::int64_t t_us = 0;
  double x_mm = 0.0, y_mm = 0.0;
  double vx_mm_s = 0.0, vy_mm_s = 0.0;
  Material ink = Material::kA;  ///< of the jet that was triggered
  double volume_share = 1.0;    ///< of its pulse, by the droplet of the calibrated one; above 0
};

/// Returns the grid cell nearest to a position; (i, j) may lie outside the grid.
struct NearestCell {
  std::int32_t i = 0, j = 0;
};
NearestCell nearest_cell(const GridSpec& grid, double x_mm, double y_mm);
/// Returns the key of a cell for the random numbers, the same on every grid with this origin and pitch.
std::uint32_t cell_key(NearestCell cell);

struct Landing {
  bool missed = false;      ///< the nozzle was triggered and no droplet came
  double volume_mm3 = 0.0;  ///< of the droplet and its satellite
  double x_mm = 0.0, y_mm = 0.0;
};

/// Holds nature's count of layers: a layer is over when its cured ink is measured. Draws are keyed by this
/// count, not by the exposures, so that prints with one cure per layer and with several see the same
/// disturbances. The count equals the exposures where every layer is cured once and measured.
class LayerCount {
 public:
  /// @returns true at the layer's first exposure.
  bool exposed() {
    ++exposures_;
    return !std::exchange(cured_, true);
  }
  /// @returns true when a new layer begins.
  bool measured() {
    if (!cured_) return false;
    ++layer_;
    cured_ = false;
    return true;
  }
  std::uint32_t exposures() const { return exposures_; }
  std::uint32_t layer() const { return layer_; }  ///< finished layers: the key of present draws

  void io(Archive& a) { a.all(exposures_, layer_, cured_); }

 private:
  std::uint32_t exposures_ = 0, layer_ = 0;
  bool cured_ = false;
};

/// The end of nature: an exception of a class in Python, or a state beyond the theory of its
/// physics.
struct NatureError : std::runtime_error {
  using runtime_error::runtime_error;
};

class Model {
 public:
  virtual ~Model() = default;
  virtual Landing fire(const Shot& shot) = 0;
  virtual void end_pass() = 0;                   ///< the jet was disarmed: landed ink has settled
  virtual void expose(std::int64_t now_us) = 0;  ///< the lamp cured the landed ink
  virtual void measured() = 0;                   ///< a scan trigger: ink cured before is a layer
  virtual const Field& surface() = 0;            ///< settled surface, for the sensor
  virtual HeightMap cell_means() const = 0;      ///< noise-free, settled
  /// The same with a margin around the grid, where the model has one.
  virtual HeightMap means_with_margin() const { return cell_means(); }
  /// Returns the same surface on the model's own cells; empty: it has none between those of the grid.
  virtual HeightMap fine_surface() const { return {}; }
  virtual VolumeLedger ledger() const = 0;
  virtual double volume_mm3() const = 0;
  virtual const LayerCount& layers() const = 0;
  /// Largest values since the print began; empty: the nature has no such limits.
  virtual std::vector<Validity> validity() const { return {}; }
  /// Returns the columns of inks: settled (lu2015), or as last cured (droplets). No cells unless
  /// WorldConfig::two_inks.
  virtual MaterialColumns materials() const = 0;
  virtual void io(Archive& a) = 0;
};

/// Returns the nature that config.model names: a word of kNatureNames, or a class in Python.
/// @throws std::invalid_argument for another name
std::unique_ptr<Model> make_model(const WorldConfig& config);
std::unique_ptr<Model> make_droplet_model(const WorldConfig& config);
std::unique_ptr<Model> make_lu2015_model(const WorldConfig& config);
std::unique_ptr<Model> make_wu_chiu_model(const WorldConfig& config);
std::unique_ptr<Model> make_graph_flow_model(const WorldConfig& config);
std::unique_ptr<Model> make_thin_film_model(const WorldConfig& config);

}  // namespace firn::plant
