// Runs the process `gas`: its node on the bus. See procs/gas/node.h.
#include "procs/gas/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) { return firn::node_main(argc, argv, firn::NodeId::kGas, firn::make_gas); }
