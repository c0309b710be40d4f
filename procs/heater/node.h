// HeaterNode connects the heaters to the bus: HEATER_COMMAND, ENABLE, SAFE_STOP, instrument -> TEMPERATURE,
// ANSWER_HEATER, STATE_HEATER, FAULT_HEATER.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/heater/heater_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/heater_command_t.hpp"
#include "firn/temperature_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/heater: receives set points, publishes a TEMPERATURE at every reading.
class HeaterNode final
    : public DriverNode<HeaterNode, drivers::Some<drivers::HeaterDriver>, drivers::Effects> {
 public:
  explicit HeaterNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const heater_command_t&, Time now, Outbox&);
  void on_measured(const drivers::Temperatures&, Time now, Outbox&);
};

std::unique_ptr<Node> make_heater(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
