#include "cli/node_makers.h"

#include "cli/targets.h"
#include "procs/controller/node.h"
#include "procs/safety/node.h"
#include "procs/scheduler/node.h"

namespace firn {

std::span<const NamedMaker> node_makers() {
  static constexpr NamedMaker kMakers[] = {
      {NodeId::kScheduler, &make_scheduler},
      {NodeId::kController, &make_controller_node},
      {NodeId::kSafety, &make_safety},
  };
  return kMakers;
}

Subscriptions all_subscriptions() {
  const Experiment experiment;
  const std::string config = dump(experiment);
  const Blobs inputs = make_inputs(experiment, "");
  Subscriptions out;
  for (const NamedMaker& maker : node_makers()) {
    const std::unique_ptr<Node> node = maker.make(config, inputs);
    for (const Node::Route& route : node->routes()) out[std::string(route.channel)].emplace(info(maker.id).name);
  }
  return out;
}

}  // namespace firn
