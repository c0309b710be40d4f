// Runs the process `jet`: its node on the bus. See procs/jet/node.h.
#include "procs/jet/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) { return firn::node_main(argc, argv, firn::NodeId::kJet, firn::make_jet); }
