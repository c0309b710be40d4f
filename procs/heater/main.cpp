// Runs the process `heater`: its node on the bus. See procs/heater/node.h.
#include "procs/heater/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kHeater, firn::make_heater);
}
