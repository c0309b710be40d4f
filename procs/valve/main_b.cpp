// Runs the process `valve_b`: the node of the scaffold's valve on the bus. See procs/valve/node.h.
#include "procs/valve/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kValveB, firn::make_valve_b);
}
