// node_main holds the whole main of a node's process.
#pragma once

#include "runtime/node.h"

namespace firn {

/// Parses the command line (runtime/process_args.h), builds the node, joins the bus, runs.
/// @returns 0, 1 not brought back, 2 usage or configuration, 3 the node failed
int node_main(int argc, char** argv, NodeId node, MakeNode make);

}  // namespace firn
