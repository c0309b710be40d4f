// Runs the process `droplet_watch`: its node on the bus. See procs/droplet_watch/node.h.
#include "procs/droplet_watch/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kDropletWatch, firn::make_droplet_watch);
}
