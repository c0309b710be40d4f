#include "cli/node_makers.h"

#include "cli/targets.h"
#include "procs/controller/node.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/safety/node.h"
#include "procs/scheduler/node.h"
#include "procs/stage/node.h"
#include "procs/surface_mapper/node.h"

namespace firn {

std::span<const NamedMaker> node_makers() {
  static constexpr NamedMaker kMakers[] = {
      {NodeId::kScheduler, &make_scheduler},
      {NodeId::kSurfaceMapper, &make_surface_mapper},
      {NodeId::kController, &make_controller_node},
      {NodeId::kStage, &make_stage},
      {NodeId::kJet, &make_jet},
      {NodeId::kLaserProfiler, &make_laser_profiler},
      {NodeId::kLamp, &make_lamp},
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
