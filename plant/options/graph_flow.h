// GraphFlowOptions holds the parameters of the flow of wet ink along the edges of a graph of cells.
#pragma once

#include "core/options/option.h"

namespace firn::plant {

/// Structure after Y. Guo, J. Peters, T. Oomen, S. Mishra, "Control-oriented models for ink-jet 3D printing",
/// Mechatronics 56 (2018) 211, of which only the abstract was read: a droplet's shape is superposed, then ink
/// flows between the nodes of a graph. The equations (plant/inkjet/graph_flow.cpp) are ours, and so are all
/// values [U].
struct GraphFlowOptions {
  double side_share = 0.05;    ///< of a droplet's volume, landed on each side neighbour
  double corner_share = 0.01;  ///< on each corner neighbour
  double kappa_side = 0.02;
  double kappa_corner = 0.005;
  double range_mm = 0.02;
  int steps = 8;
  int margin_cells = 3;
  bool operator==(const GraphFlowOptions&) const = default;
};
inline constexpr OptionTable kGraphFlowOptions{
    Option{"side_share", &GraphFlowOptions::side_share, "", within(0, 0.2),
           "share of a droplet's volume that lands on each side neighbour, whatever its height [U]"},
    Option{"corner_share", &GraphFlowOptions::corner_share, "", within(0, 0.04),
           "the same of each corner neighbour [U]"},
    Option{"kappa_side", &GraphFlowOptions::kappa_side, "", within(0, 0.1),
           "share of the height difference that flows to a side neighbour in a step [U]"},
    Option{"kappa_corner", &GraphFlowOptions::kappa_corner, "", within(0, 0.1),
           "the same to a corner neighbour [U]"},
    Option{"range_mm", &GraphFlowOptions::range_mm, "mm", above(0, 10),
           "height differences beyond this drive no more flow [U]"},
    Option{"steps", &GraphFlowOptions::steps, "", within(0, 200),
           "steps of flow from a pass to the next, or to the lamp [U]"},
    Option{"margin_cells", &GraphFlowOptions::margin_cells, "cells", within(1, 50),
           "ground around the grid; ink beyond it is lost"},
};

}  // namespace firn::plant
