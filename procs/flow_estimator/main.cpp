// Runs the process `flow_estimator`: its node on the bus. See procs/flow_estimator/node.h.
#include "procs/flow_estimator/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kFlowEstimator, firn::make_flow_estimator);
}
