// Runs the process `controller`: its node on the bus, with the process's threads. See
// procs/controller/node.h.
#include "procs/controller/node.h"

#include "procs/bus/node_main.h"
#include "runtime/thread_pool.h"

int main(int argc, char** argv) {
  return firn::node_main(
      argc, argv, firn::NodeId::kController, +[](const std::string& config, const firn::Blobs& blobs) {
        return firn::make_controller_node_on(firn::parallel_on(firn::thread_count(0)), config, blobs);
      });
}
