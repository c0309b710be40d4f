// RunMaps finds and computes the surfaces of a run: measured, target, error, planned, predicted, true. Maps
// stay in the files of the run and are read as they are asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "core/grid/outline.h"
#include "core/slice/paths/print_paths.h"
#include "page/map_frame.h"
#include "runs/read/run_reader.h"

namespace firn::page {

struct MapRequest {
  Surface surface = Surface::kMeasured;
  int layer = 0;  ///< layers deposited so far; 0 = the bare substrate
};

class RunMaps {
 public:
  /// Returns a message again.
  using Reader = std::function<std::vector<std::byte>(const runs::Place&)>;
  /// @param inputs files by role, of the run's provenance; a missing or damaged one leaves surfaces out
  RunMaps(std::filesystem::path run, const Experiment& experiment,
          const std::map<std::string, std::filesystem::path>& inputs, Reader read);

  static std::set<std::string, std::less<>> channels();
  void take(std::string_view channel, std::span<const std::byte> message, runs::Place place);

  /// Returns the map as a frame; nothing: the run has no such map.
  std::optional<std::vector<std::byte>> frame(const MapRequest& request);
  /// Returns the error of a layer's map against its target [mm], NaN beside the part; nothing: the run has no
  /// such map, or no target.
  std::optional<HeightMap> error(int layer);
  std::optional<int> newest_layer() const;
  const std::optional<GridSpec>& grid() const { return grid_; }

  /// A layer's number beside a value of it.
  using Value = std::pair<int, double>;
  /// Computes the predicted RMS [um] of the layers that were planned since the last call, at most the newest
  /// forty.
  std::vector<Value> take_predictions();
  /// Computes the outlines of the layers that were measured since the last call, likewise.
  std::vector<std::pair<int, OutlineStats>> take_outlines();
  /// Counts the rows that are measured now; 0: none are.
  std::uint64_t rows_stamp() const { return rows_layer_ < 0 ? 0 : rows_stamp_; }
  /// Returns the newest map with these rows over it, as a frame; to a reader that has them up to `since`, the
  /// rows that came later.
  std::optional<std::vector<std::byte>> partial(std::uint64_t since) const;

 private:
  struct MapPlace {
    runs::Place place;
    double t_s = 0.0;
  };
  struct Measured {
    HeightMap height;
    double t_s = 0.0;
  };
  std::shared_ptr<const Measured> measured(int layer);
  /// Returns target and mask on the grid of the layer's map.
  struct Wanted {
    HeightMap target;
    Mask mask;
  };
  std::shared_ptr<const Wanted> wanted(int layer, const GridSpec& grid);
  std::optional<HeightMap> target(int layer);  // as error()
  std::optional<std::vector<std::byte>> planned(int layer);
  std::optional<Measured> predicted(int layer);
  std::optional<Measured> truth(int layer);
  void on_profile(std::span<const std::byte> message);

  std::filesystem::path run_;
  const Experiment& experiment_;
  Reader read_;
  bool paths_ = false;  // the lab prints paths
  std::shared_ptr<const Wanted> droplets_;
  std::pair<int, std::shared_ptr<const Measured>> last_{-1, nullptr};  // that was decoded, with its layer
  std::optional<slice::PrintPaths> layers_;
  deposition::DropletModel model_;
  std::optional<GridSpec> grid_;
  std::map<int, MapPlace> maps_, plans_, surfaces_;  // by layer of the map, of the plan, of the map answered
  std::vector<int> new_plans_, new_maps_;
  HeightMap rows_;
  int rows_layer_ = -1;
  double rows_s_ = 0.0;
  std::uint64_t rows_stamp_ = 0, first_stamp_ = 0;  // of the newest row; before the first of this layer
  std::vector<std::uint64_t> stamps_;               // of the rows of rows_
};

}  // namespace firn::page
