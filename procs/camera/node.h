// CameraNode connects the camera to the bus: CAMERA_COMMAND, ENABLE, SAFE_STOP, instrument -> CAMERA_FRAME,
// CAMERA_PREVIEW, ANSWER_CAMERA, STATE_CAMERA, FAULT_CAMERA. The node takes part only with camera.use = "on".
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/camera/camera_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/camera_command_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/camera. A picture is sent as a PNG, which the run's log keeps; its time is that of the
/// exposure: now less the age that the camera states. Previews are at most 200 px wide and camera.preview_s
/// apart.
class CameraNode final
    : public DriverNode<CameraNode, drivers::Some<drivers::CameraDriver>, drivers::Effects> {
 public:
  explicit CameraNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const camera_command_t&, Time now, Outbox&);
  void on_measured(drivers::CameraShot&, Time now, Outbox&);

 private:
  void send_preview(const drivers::Picture& picture, Time now, Outbox&);

  double preview_s_;
  camera_command_t sweep_{};  // in progress
  Time preview_after_;
};

std::unique_ptr<Node> make_camera(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
