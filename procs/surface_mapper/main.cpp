// Runs the process `surface_mapper`: its node on the bus. See procs/surface_mapper/node.h.
#include "procs/surface_mapper/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kSurfaceMapper, firn::make_surface_mapper);
}
