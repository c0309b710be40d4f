// Runs the process `lamp`: its node on the bus. See procs/lamp/node.h.
#include "procs/lamp/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) { return firn::node_main(argc, argv, firn::NodeId::kLamp, firn::make_lamp); }
