// The process `controller`: its node on the bus. See procs/controller/node.h.
#include "procs/controller/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kController, firn::make_controller_node);
}
