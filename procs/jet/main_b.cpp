// Runs the process `jet_b`: the node of the second jet on the bus. See procs/jet/node.h.
#include "procs/jet/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) { return firn::node_main(argc, argv, firn::NodeId::kJetB, firn::make_jet_b); }
