// Runs the process `camera`: its node on the bus. See procs/camera/node.h.
#include "procs/camera/node.h"

#include "procs/bus/node_main.h"

int main(int argc, char** argv) {
  return firn::node_main(argc, argv, firn::NodeId::kCamera, firn::make_camera);
}
