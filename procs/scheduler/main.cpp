// Runs the process `scheduler`: its node on the bus. See procs/scheduler/scheduler.h.
#include "procs/scheduler/scheduler.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kScheduler, firn::make_scheduler);
}
