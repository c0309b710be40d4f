// Runs the process `laser_point`: its node on the bus. See procs/laser_point/node.h.
#include "procs/laser_point/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kLaserPoint, firn::make_laser_point);
}
