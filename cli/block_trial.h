// One print of a block of two inks by a feedback scheme on the simulated plant, without the lab: each droplet lands in
// the middle of its cell, each cell is measured once per layer with the sensor's noise. For the papers' tables.
#pragma once

#include <cstdint>
#include <memory>

#include "config/experiment.h"
#include "core/grid/geometry.h"
#include "core/grid/material_columns.h"
#include "runtime/node.h"

namespace firn {

struct BlockTrial {
  MaterialColumns printed;  ///< nature's truth
  HeightMap height;         ///< of the block, noise-free
  int layers = 0;
  std::int64_t droplets = 0;
  double decide_cpu_s = 0.0;  ///< processor time of all decisions; differs from run to run
  bool ended = false;         ///< by the scheme; false: at control.max_layers
};

/// Prints `experiment` (two inks) with `inputs` (make_inputs). Thread-safe. @throws std::invalid_argument, ConfigError
BlockTrial print_block(const Experiment& experiment, const Blobs& inputs);

}  // namespace firn
