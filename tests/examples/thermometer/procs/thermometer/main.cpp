// The process `thermometer`: its node on the bus. See procs/thermometer/node.h.
#include "procs/thermometer/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kThermometer, firn::make_thermometer);
}
