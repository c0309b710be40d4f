// ControllerNode computes the plan of the next layer from a height map: HEIGHT_MAP -> LAYER_PLAN, with the
// ink of each cell for parts of two inks. The node runs any scheme of core/control, without bus or clock.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "config/changes.h"
#include "config/experiment.h"
#include "core/control/controller.h"
#include "core/control/known_surface.h"
#include "firn/height_map_t.hpp"
#include "firn/height_model_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/own_height_model_t.hpp"
#include "procs/controller/height_estimate.h"
#include "runtime/node.h"

namespace firn {

/// Answers every height map with the plan of the next layer (map.layer + 1), echoing map_id and attempt.
/// A map that cannot be used (another grid, sizes that disagree, a height on the part that is not finite) is
/// answered with a fault and a plan to stop for the operator; the scheme's state does not change. With
/// control.height_estimate = "kalman" the scheme receives the map blended with the height predicted from the
/// executed droplets. A map that overtakes the reports of its layer waits for these reports, at most two
/// seconds; then the map counts alone. A cell that a scan has not measured is decided by the model's height
/// (core/control/known_surface.h), not by the map's guess, if the map counts the rows of its scan. Scheme
/// auto receives the map, and beside it the blended height where one is known (one ink, raw maps, droplets in
/// the middles of their cells), with droplet factors "together". A decision's notice is reported as a notice.
class ControllerNode final : public Node {
 public:
  /// @throws std::invalid_argument naming the setup field or option that the scheme refuses.
  /// @param geometry of two inks; null: one ink
  /// @param inputs with the files of a scheme in Python
  ControllerNode(const Experiment& experiment, HeightMap target, Mask mask,
                 std::shared_ptr<const Geometry> geometry = nullptr, const Blobs& inputs = {});
  void on(const height_map_t&, Time now, Outbox&);
  /// With control.adapt_model: later decisions use the model. A decision does not wait for a model: a map is
  /// answered with the newest model received.
  void on(const height_model_t&, Time now, Outbox&);
  /// With control.adapt_model = "own:NAME": the same with the models of that program.
  void on(const own_height_model_t&, Time now, Outbox&);
  /// With control.height_estimate = "kalman".
  void on(const deposition_report_t&, Time now, Outbox&);
  /// The operator's change of an option: later decisions use it.
  void on(const operator_command_t&, Time now, Outbox&);
  void wake(TimerId, Time now, Outbox&) override;
  /// Sets the parallel loop for the computation of a decision; the result has the same bytes. The node itself
  /// starts no thread.
  void use_threads(const ParallelFor& parallel) { scheme_->use_threads(parallel); }

 private:
  void answer(const height_map_t& map, Outbox& out);
  control::Decision decide(const height_map_t& map);
  control::Decision decide_on_map(const height_map_t& map);

  Changes changes_;
  std::string own_source_;  ///< the program of the lab's own whose OWN_HEIGHT_MODEL counts; empty: none
  GridSpec grid_;
  bool beside_map_;  ///< scheme auto: the estimate goes beside the map, not in its place
  std::unique_ptr<control::LayerController> scheme_;
  control::KnownSurface known_;             ///< of decisions on the map
  deposition::DropletModel model_;          ///< as configured
  std::optional<HeightEstimate> estimate_;  ///< "kalman"
  double wait_s_;
  std::optional<height_map_t> waiting_;  ///< for the reports of its layer
};

/// Returns the scheme of an experiment, in C++ or in Python.
/// @param inputs with the files of a scheme in Python
/// @throws std::invalid_argument naming the option that the scheme refuses; std::runtime_error with the
/// traceback of an exception in Python
std::unique_ptr<control::LayerController> make_scheme(const control::Setup& setup,
                                                      const control::ControlOptions& options,
                                                      const Blobs& inputs);

/// Returns the configuration of a scheme as core's structs.
control::ControlOptions control_options(const Experiment& experiment);
control::Setup control_setup(const Experiment& experiment, HeightMap target, Mask mask,
                             std::shared_ptr<const Geometry> geometry = nullptr);

std::unique_ptr<Node> make_controller_node(const std::string& config_toml, const Blobs& blobs);
std::unique_ptr<Node> make_controller_node_on(const ParallelFor& parallel, const std::string& config_toml,
                                              const Blobs& blobs);

}  // namespace firn
