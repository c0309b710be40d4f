// Converts messages to core's types and back: the only place where lcmtypes meets core.
#pragma once

#include <optional>
#include <string>

#include "core/grid/figure.h"
#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"
#include "core/path/trajectory_codec.h"
#include "firn/deposition_report_t.hpp"
#include "firn/figure_t.hpp"
#include "firn/grid_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "firn/stage_command_t.hpp"
#include "firn/trajectory_t.hpp"

namespace firn {

grid_t to_message(const GridSpec& spec);
figure_t to_message(const Figure& figure);  ///< a number that is not finite counts as not known
GridSpec from_message(const grid_t& grid);
Figure from_message(const figure_t& figure);

HeightMap height_of(const height_map_t& map);  ///< NaN where not measured
/// The same, NaN also where the map guesses the height; a map that does not count its rows names no guesses.
HeightMap measured_height_of(const height_map_t& map);
void set_height(height_map_t& map, const HeightMap& height);
DropletPattern drops_of(const layer_plan_t& plan);
DropletPattern drops_of(const deposition_report_t& report);  ///< as the pass commanded
void set_drops(layer_plan_t& plan, const DropletPattern& drops);
MaterialMap materials_of(const layer_plan_t& plan);  ///< without cells: one ink
void set_materials(layer_plan_t& plan, const MaterialMap& materials);
OffsetMap offsets_of(const layer_plan_t& plan);  ///< without cells: all in the centres
void set_offsets(layer_plan_t& plan, const OffsetMap& offsets);
DropletPattern fires_of(const stage_command_t& pass);  ///< 1 where the pass fires
/// Returns the places of a pass's droplets; check() tells an index beyond the table.
Placement placement_of(const stage_command_t& pass, const OffsetTable& table);
void set_placement(stage_command_t& pass, const Placement& placement);

/// Path, positions and certificate; the header is the sender's.
trajectory_t to_message(const PlannedPath& path);
/// @pre validate() passes
PlannedPath from_message(const trajectory_t& message);

}  // namespace firn
