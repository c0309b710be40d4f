// controller: HEIGHT_MAP -> LAYER_PLAN, with the ink of each cell where there are two. Any scheme of
// core/control; knows no bus, no clock.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "config/experiment.h"
#include "core/control/controller.h"
#include "firn/height_map_t.hpp"
#include "firn/height_model_t.hpp"
#include "procs/controller/height_estimate.h"
#include "runtime/node.h"

namespace firn {

/// Answers every height map with the plan of the next layer (map.layer + 1), echoing map_id and attempt.
/// A map that cannot be used (another grid, sizes that disagree, a height on the part that is not finite) is
/// answered with a fault and a plan to stop for the operator; it leaves the scheme's state as it was.
/// With control.height_estimate = "kalman" the scheme sees the map blended with what the executed droplets
/// must have added. A map that overtakes the reports of its layer waits for them, two seconds at most; then
/// it counts alone.
class ControllerNode final : public Node {
 public:
  /// @throws std::invalid_argument naming the setup field or option that the scheme refuses.
  /// @param geometry of two inks; null: one ink
  ControllerNode(const Experiment& experiment, HeightMap target, Mask mask,
                 std::shared_ptr<const Geometry> geometry = nullptr);
  void on(const height_map_t&, Time now, Outbox&);
  /// With control.adapt_model: later decisions plan with it. A decision does not wait for it: a map is
  /// answered with the newest model that has come.
  void on(const height_model_t&, Time now, Outbox&);
  /// With control.height_estimate = "kalman".
  void on(const deposition_report_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;
  /// What a decision may do side by side, with the same bytes; the node itself starts no thread.
  void use_threads(const ParallelFor& parallel) { scheme_->use_threads(parallel); }

 private:
  void answer(const height_map_t& map, Outbox& out);
  control::Decision decide(const height_map_t& map);

  GridSpec grid_;
  std::unique_ptr<control::LayerController> scheme_;
  deposition::DropletModel model_;          ///< as configured
  std::optional<HeightEstimate> estimate_;  ///< "kalman"
  double wait_s_;
  std::optional<height_map_t> waiting_;  ///< for the reports of its layer
};

/// What the configuration says of a scheme, in core's terms.
control::ControlOptions control_options(const Experiment& experiment);
control::Setup control_setup(const Experiment& experiment, HeightMap target, Mask mask,
                             std::shared_ptr<const Geometry> geometry = nullptr);

std::unique_ptr<Node> make_controller_node(const std::string& config_toml, const Blobs& blobs);
std::unique_ptr<Node> make_controller_node_on(const ParallelFor& parallel, const std::string& config_toml,
                                              const Blobs& blobs);

}  // namespace firn
