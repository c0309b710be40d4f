// Runs the process `stage`: its node on the bus. See procs/stage/node.h.
#include "procs/stage/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kStage, firn::make_stage);
}
