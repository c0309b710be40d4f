// DropletWatchNode measures the jet's droplets in strobe pictures: CAMERA_FRAME -> DROPLET_SWEEP. The node
// takes part only with camera.use = "on".
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "core/vision/frame.h"
#include "firn/camera_frame_t.hpp"
#include "runtime/node.h"

namespace firn {

/// Collects the pictures of a sweep; the last one, or the first of another sweep, ends it. A picture that
/// cannot be decoded is left out with a warning. The static background is that of the sweep's own pictures.
class DropletWatchNode final : public Node {
 public:
  explicit DropletWatchNode(const Experiment& experiment);
  void on(const camera_frame_t&, Time now, Outbox&);

 private:
  struct Picture {
    double delay_us = 0.0;
    vision::Frame frame;
  };
  void measure(Outbox&);

  droplet::WatchOptions options_;
  camera_frame_t first_{};  // without its bytes
  std::vector<Picture> pictures_;
};

std::unique_ptr<Node> make_droplet_watch(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
