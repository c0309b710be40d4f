#include "cli/node_makers.h"

#include "cli/run_config.h"
#include "cli/targets.h"
#include "procs/controller/node.h"
#include "procs/droplet_estimator/node.h"
#include "procs/jet/node.h"
#include "procs/lamp/node.h"
#include "procs/laser_profiler/node.h"
#include "procs/safety/node.h"
#include "procs/scheduler/scheduler.h"
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
      {NodeId::kJetB, &make_jet_b},
      {NodeId::kSafety, &make_safety},
      {NodeId::kDropletEstimator, &make_droplet_estimator},
  };
  return kMakers;
}

std::vector<NamedMaker> taking_part(const Experiment& e) {
  std::vector<NamedMaker> out;
  for (const NamedMaker& m : node_makers())
    if (takes_part(e, info(m.id).name)) out.push_back(m);
  return out;
}

std::vector<NamedMaker> taking_part(const std::filesystem::path& run) {
  try {
    return taking_part(parse_experiment(recorded_config(run), "the recorded configuration"));
  } catch (const std::exception&) {  // replay says what is wrong with it
    std::vector<NamedMaker> out = taking_part(Experiment{});
    for (const NamedMaker& m : node_makers())
      if (!takes_part(Experiment{}, info(m.id).name) && std::filesystem::exists(run / "nodes" / (std::string(info(m.id).name) + ".wal")))
        out.push_back(m);
    return out;
  }
}

Subscriptions all_subscriptions() {
  Experiment experiment;
  experiment.estimator.droplets = experiment.control.adapt_model = "on";
  experiment.control.height_estimate = "kalman";
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
