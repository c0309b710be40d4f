// place_droplets() computes a locally optimal layer whose droplets have places inside their cells.
#pragma once

#include "core/control/mpc/greedy.h"
#include "core/control/mpc/placed_objective.h"
#include "core/grid/random.h"

namespace firn::control::mpc {

/// Improves the layer that `objective` holds: cell after cell, in an order drawn from `random`, takes the
/// best of its places and no droplet, others fixed, until none changes; then pairs of cells within two
/// columns and rows of each other, of which one changes to any of its choices and the other answers with its
/// best. Ends when neither a cell nor a pair improves (`optimal`), or after most_evaluations places looked
/// at. The objective never rises.
SearchResult place_droplets(PlacedObjective& objective, std::int64_t most_evaluations, RandomStream& random);

}  // namespace firn::control::mpc
