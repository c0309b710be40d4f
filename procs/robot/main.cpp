// Runs the process `robot`: its node on the bus. See procs/robot/node.h.
#include "procs/robot/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kRobot, firn::make_robot);
}
