// The process `path_planner`: its node on the bus. See procs/path_planner/node.h.
#include "procs/path_planner/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kPathPlanner, firn::make_path_planner);
}
