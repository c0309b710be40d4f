// Runs the process `laser_profiler`: its node on the bus. See procs/laser_profiler/node.h.
#include "procs/laser_profiler/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kLaserProfiler, firn::make_laser_profiler);
}
