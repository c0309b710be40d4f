// controller: HEIGHT_MAP -> LAYER_PLAN.
#include "procs/bus/node_main.h"
#include "procs/controller/node.h"

int main(int argc, char** argv) { return firn::node_main(argc, argv, firn::NodeId::kController, firn::make_controller_node); }
