// Runs the process `droplet_estimator`: its node on the bus. See procs/droplet_estimator/node.h.
#include "procs/droplet_estimator/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kDropletEstimator, firn::make_droplet_estimator);
}
