// LaserPointNode connects the point laser to the bus: LASER_COMMAND, ENABLE, SAFE_STOP, instrument ->
// LASER_SAMPLES, ANSWER_LASER_POINT, STATE_LASER_POINT, FAULT_LASER_POINT.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/laser_point/laser_point_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/laser_command_t.hpp"
#include "firn/laser_samples_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/laser_point. LASER_SAMPLES of a collect carries the path of the command that armed the
/// storage.
class LaserPointNode final
    : public DriverNode<LaserPointNode, drivers::Some<drivers::LaserPointDriver>, drivers::Effects> {
 public:
  /// @throws std::invalid_argument: a sampling time or averaging that the instrument lacks
  explicit LaserPointNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const laser_command_t&, Time now, Outbox&);
  void on_measured(drivers::Samples&, Time now, Outbox&);

 private:
  laser_command_t armed_{};    // whose samples are stored
  laser_command_t reading_{};  // the single reading asked for last
};

std::unique_ptr<Node> make_laser_point(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
