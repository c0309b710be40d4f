#include "print/folder/node_makers.h"
#include "print/inputs/mesh_inputs.h"
#include "print/labs/inkjet_print.h"
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

std::span<const PrintLab* const> print_labs() {
  static constexpr const PrintLab* kLabs[] = {&kInkjetPrint};
  return kLabs;
}

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

const MeshInputs* mesh_inputs() { return nullptr; }

}  // namespace firn
