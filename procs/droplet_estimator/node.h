// DropletEstimatorNode estimates the height model of the droplets: DEPOSITION_REPORT, HEIGHT_MAP,
// DROPLET_SWEEP
// -> HEIGHT_MODEL. The node takes part unless estimator.droplets = "off".
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "config/experiment.h"
#include "estimators/droplet/droplet_estimator.h"
#include "estimators/droplet/layer_drops.h"
#include "firn/deposition_report_t.hpp"
#include "firn/droplet_sweep_t.hpp"
#include "firn/height_map_t.hpp"
#include "procs/droplet_estimator/python_estimator.h"
#include "runtime/node.h"

namespace firn {

/// Publishes h1, h2, h3 after every layer, with their covariance and a measure of how well the patterns
/// separate them. A map that arrives before the last report of its layer waits for that report (maps and
/// reports have separate channels), at most until the next map. A second map of a layer replaces the first.
/// Unusable input (another grid, a map without heights) causes a warning and changes nothing; an exception of
/// a class in Python stops the print.
class DropletEstimatorNode final : public Node {
 public:
  /// @throws std::invalid_argument naming the field that the estimator refuses.
  /// @param inputs of an estimator in Python
  DropletEstimatorNode(const Experiment& experiment, Mask mask, const Blobs& inputs = {});
  void on(const deposition_report_t&, Time now, Outbox&);
  void on(const height_map_t&, Time now, Outbox&);
  void on(const droplet_sweep_t&, Time now, Outbox&);

 private:
  void learn(const height_map_t& map, Outbox& out);
  /// @throws std::invalid_argument: a map that changes nothing; std::runtime_error: of a class in Python
  const droplet::Estimate& estimate_with(const height_map_t& map, const droplet::LayerDrops& drops,
                                         const std::vector<droplet::Use>& use, double noise_std_mm);
  void publish(const height_map_t& map, const droplet::Estimate& estimate, Outbox& out);

  GridSpec grid_;
  Mask mask_;
  droplet::DropletEstimator estimator_;
  std::unique_ptr<PythonEstimator> python_;  ///< in its place
  droplet::LayerDrops drops_;
  int layer_ = 0;     ///< of drops_
  int learned_ = -1;  ///< newest layer whose map has been used
  std::optional<height_map_t> waiting_;
};

std::unique_ptr<Node> make_droplet_estimator(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
