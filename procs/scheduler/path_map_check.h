// Checks of a path printer's height maps compute why a map contradicts the calibration of the lab, or the
// volume that the valves were to lay; empty = no contradiction.
#pragma once

#include "config/experiment.h"
#include "core/grid/figure.h"
#include "core/grid/grid.h"
#include "core/slice/paths/print_paths.h"
#include "firn/height_map_t.hpp"

namespace firn {

struct FirstMapDoubt {
  Violation stop;     ///< place or height contradicts the calibration
  Violation warning;  ///< the laser's height or a valve's flow does, and only a map of the table tells which
};

/// I15: the bare table, or the first interval, against the calibrated uncertainty.
/// @param bare map of the table; without cells = not measured
FirstMapDoubt doubt_of_first_map(const Experiment&, const slice::PrintPaths&, const height_map_t&,
                                 const HeightMap& bare);

struct ValveDoubt {
  Violation violation;  ///< its figure is the rise as a share of the nominal one
  bool much = false;    ///< the valve gives too much, not too little
};

/// I12: a valve that gives nothing or too much, by the rise between two maps.
/// @param layers laid between the two, the last one `layer`
/// @param before the map of the interval before; without cells = the table
ValveDoubt disturbed_valve(const Experiment&, const slice::PrintPaths&, int layer, int layers,
                           const HeightMap& newest, const HeightMap& before);

/// I12: a surface that rose between two measurements of one layer, where nothing was to be laid.
Violation rise_without_command(const Experiment&, int layer, const HeightMap& before,
                               const HeightMap& height);

}  // namespace firn
