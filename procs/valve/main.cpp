// Runs the process `valve_a`: its node on the bus. See procs/valve/node.h.
#include "procs/valve/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kValveA, firn::make_valve_a);
}
