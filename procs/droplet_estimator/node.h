// droplet_estimator: DEPOSITION_REPORT, HEIGHT_MAP -> HEIGHT_MODEL.   Takes part only with estimator.droplets
// = "on".
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "config/experiment.h"
#include "estimators/droplet/droplet_estimator.h"
#include "estimators/droplet/layer_drops.h"
#include "firn/deposition_report_t.hpp"
#include "firn/height_map_t.hpp"
#include "runtime/node.h"

namespace firn {

/// After every layer: h1, h2, h3 with their covariance and how far the patterns have told them apart. A map
/// that comes before the last report of its layer waits for it (they travel on two channels), at most until
/// the next map. A second map of a layer replaces the first. What cannot be used (another grid, a map without
/// heights) is named in a warning and changes nothing.
class DropletEstimatorNode final : public Node {
 public:
  /// @throws std::invalid_argument naming the field that the estimator refuses.
  DropletEstimatorNode(const Experiment& experiment, Mask mask);
  void on(const deposition_report_t&, Time now, Outbox&);
  void on(const height_map_t&, Time now, Outbox&);

 private:
  void learn(const height_map_t& map, Outbox& out);
  void publish(const height_map_t& map, Outbox& out);
  void warn(const std::string& text, Outbox& out) const;

  GridSpec grid_;
  Mask mask_;
  droplet::DropletEstimator estimator_;
  droplet::LayerDrops drops_;
  int layer_ = 0;     ///< of drops_
  int learned_ = -1;  ///< newest layer whose map has been taken in
  std::optional<height_map_t> waiting_;
};

std::unique_ptr<Node> make_droplet_estimator(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
