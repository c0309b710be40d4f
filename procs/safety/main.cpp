// Runs the process `safety`: its node on the bus. See procs/safety/node.h.
#include "procs/safety/node.h"

#include "procs/bus/node_main.h"
#include "runtime/precedence.h"

int main(int argc, char** argv) {
  const firn::Precedence precedence;
  return firn::node_main(argc, argv, firn::NodeId::kSafety, firn::make_safety);
}
