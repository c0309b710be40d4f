// Runs the process `path_planner`: its node on the bus, with the process's threads. See
// procs/path_planner/node.h.
#include "procs/path_planner/node.h"

#include "procs/bus/node_main.h"
#include "runtime/thread_pool.h"

int main(int argc, char** argv) {
  return firn::node_main(
      argc, argv, firn::NodeId::kPathPlanner, +[](const std::string& config, const firn::Blobs& blobs) {
        return firn::make_path_planner_on(firn::parallel_on(firn::thread_count(0)), config, blobs);
      });
}
