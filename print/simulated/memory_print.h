// Runs a whole print in this process and in simulated time without files: no run folder, no write-ahead
// files, no log. The nodes and the world are those of `firn print`, so the printed part is the same to the
// last bit. For studies, tests and the papers' tables, which print thousands of parts.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "core/grid/material_columns.h"
#include "core/grid/outline.h"
#include "print/labs/product.h"
#include "print/simulated/line_truth.h"
#include "runs/folder/run_folder.h"
#include "runtime/node.h"

namespace firn {

namespace plant {
struct WorldConfig;
}

struct MemoryPrintOptions {
  bool series = false;                    ///< fill `series`
  bool surface = false;                   ///< fill `surface`
  bool outline = false;                   ///< fill `outline`
  bool materials = false;                 ///< fill `materials`
  std::optional<GridSpec> ice_over = {};  ///< ice lab: fill `ice` over this grid
  bool ice_each = false;                  ///< with series and ice_over: fill `ice_each`
  /// Receives every message when it is sent.
  std::function<void(std::string_view channel, std::span<const std::byte> bytes)> tap = {};
  /// Changes nature beyond the keys of [plant], before the world is made.
  std::function<void(plant::WorldConfig&)> nature = {};
};

/// Holds the true surface after a layer, which no node knows. Errors are height - target over the mask.
struct LayerTruth {
  int layer = 0;                    ///< 1-based
  std::int64_t droplets_total = 0;  ///< triggers that the jet obeyed so far
  double volume_mm3 = 0.0;          ///< on the field
  double node_s = 0.0;              ///< simulated time
  ErrorStats error;
  double deposit_s = 0.0, measure_s = 0.0;  ///< this layer's, as LAYER_METRICS reports them
};

struct MemoryPrintReport {
  runs::RunResult result;     ///< status 0 = the scheme finished the part; all else is a print that failed
  ErrorStats error;           ///< of the true final surface about the target, over the mask
  OutlineStats outline;       ///< with `outline` asked for: of the true final part
  std::int64_t droplets = 0;  ///< triggers that the jet obeyed
  std::int64_t droplets_missed = 0;  ///< of these, triggers without a droplet
  std::int64_t passes = 0;           ///< DEPOSITION_REPORTs: passes of the stage that fired droplets
  double volume_mm3 = 0.0;           ///< on the field
  double node_s = 0.0;               ///< simulated duration of the print
  std::int64_t iterations = 0;       ///< of the controller's search, summed over all decisions
  double decide_cpu_s = 0.0;         ///< processor time in the controller; differs from run to run
  std::vector<LayerTruth> series;
  LineTruth lines;                  ///< aerosol lab
  LineLooks looks;                  ///< the same as its camera sees it
  LinePaths paths;                  ///< and the paths that its stage followed
  HeightMap surface;                ///< noise-free mean over each cell [mm]
  MaterialColumns materials;        ///< two inks: the materials of the block
  HeightMap ice;                    ///< ice lab: thickness of the ice, without scaffold; NaN off the field
  std::vector<HeightMap> ice_each;  ///< the same after each layer of `series`
};

/// Prints `experiment` with `inputs` (make_inputs) by the nodes of the product. Thread-safe: any number of
/// prints may run at once.
/// @throws std::invalid_argument, ConfigError: inputs or plant that cannot be; std::runtime_error: the lab
/// does not advance.
MemoryPrintReport print_in_memory(const Product& product, const Experiment& experiment, const Blobs& inputs,
                                  const MemoryPrintOptions& options = {});

}  // namespace firn
