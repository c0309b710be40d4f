// edge_bound() computes the least overspill that any pattern of droplets can have under Lu's model.
#pragma once

#include <string>

#include "core/deposition/height_change.h"
#include "core/grid/grid.h"

namespace firn {

/// Returns the least volume outside the mask, over the target's inside it, of any number of layers of any
/// droplets on the cells of the part whose mean absolute error inside is at most `mean_abs_mm`; in parts, as
/// OutlineStats::overspill. It holds for the height-change model [Lu 2015, Eqs. (3)-(5)] as long as the
/// ground beside the part is lower than its rim, whatever the order of the droplets.
///
/// A linear programme: droplets n_c >= 0 of each cell, and for every ordered pair of neighbours inside the
/// part a height 0 <= g_ct <= w_ct n_c that c gives to t; w = h2 at a side, h3 at a corner. The heights w n_c
/// that cells give to ground beside the part are the overspill, whose sum is minimised; the rest must be the
/// target up to errors of the wanted mean. The model's sat() lets one of each pair give all of w; leaving
/// that out only widens the choice, so the value stays a bound (docs/algorithms/edges.md).
///
/// CBC (Debian: coinor-cbc) solves it: for studies, not for nodes.
/// @param border of the grid: kLose counts what goes over it as overspill, kKeep is a wall
/// @throws std::invalid_argument: maps of different sizes, a part without volume, a negative error
/// @throws std::runtime_error: CBC is not installed, or found no optimum
double edge_bound(const HeightMap& target, const Mask& mask, const deposition::DropletModel& model,
                  deposition::Border border, double mean_abs_mm);

/// Returns true if the solver that edge_bound() runs is installed.
bool has_edge_solver();

/// Returns the programme as text in CPLEX's LP format, heights in um.
std::string edge_programme(const HeightMap& target, const Mask& mask, const deposition::DropletModel& model,
                           deposition::Border border, double mean_abs_mm);

}  // namespace firn
