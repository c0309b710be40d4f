// SurfaceControllerNode computes the action of a path printer from a height map: HEIGHT_MAP ->
// CONTROL_SURFACE. The node runs any scheme of core/control/surface.
#pragma once

#include <memory>
#include <optional>

#include "config/changes.h"
#include "config/experiment.h"
#include "core/control/surface/surface_controller.h"
#include "core/slice/paths/print_paths.h"
#include "firn/flow_model_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/own_flow_model_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Answers every height map of a layer of the print with the action for the layers above it, echoing map_id
/// and attempt. A map below process.min_measured_fraction is not answered: the scheduler measures again or
/// stops (I13). An unusable map is answered with a fault and a decision to stop; the scheme's state does not
/// change.
class SurfaceControllerNode final : public Node {
 public:
  /// @throws std::invalid_argument naming the option that the scheme refuses; paths without a layer
  /// @param inputs of a scheme in Python
  SurfaceControllerNode(const Experiment& experiment, slice::PrintPaths paths, const Blobs& inputs = {});
  /// Handles a resume: the operator has inspected the lab.
  void start(const Start&, Time now, Outbox&) override;
  void on(const height_map_t&, Time now, Outbox&);
  /// With flow.feed_forward: the estimate of the valves from the map of the same map_id. That map waits for
  /// the estimate.
  void on(const flow_model_t&, Time now, Outbox&);
  /// With flow.feed_forward = "own:NAME": the newest estimate of that program; no map waits for it.
  void on(const own_flow_model_t&, Time now, Outbox&);
  /// The operator's change of an option: later decisions use it.
  void on(const operator_command_t&, Time now, Outbox&);

 private:
  control::SurfaceDecision decide(const height_map_t& map);
  void answer(const height_map_t& map, Outbox&);

  Changes changes_;
  slice::PrintPaths paths_;
  double pitch_mm_, min_measured_fraction_;
  control::SurfaceVersion version_;
  std::string own_source_;  ///< the program of the lab's own whose OWN_FLOW_MODEL counts; empty: none
  bool feed_forward_;       ///< maps wait for FLOW_MODEL
  std::unique_ptr<control::SurfaceController> scheme_;
  std::optional<height_map_t> waiting_;  ///< for its FLOW_MODEL
  std::int64_t told_ = -1;               ///< map of the last FLOW_MODEL
};

}  // namespace firn
