// GasNode connects the mass-flow controllers to the bus: GAS_COMMAND, ENABLE, SAFE_STOP, instrument ->
// GAS_FLOW, ANSWER_GAS, STATE_GAS, FAULT_GAS.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/gas/gas_driver.h"
#include "drivers/link/some_driver.h"
#include "firn/gas_command_t.hpp"
#include "firn/gas_flow_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/gas: receives set points, publishes a GAS_FLOW at every round of readings.
class GasNode final : public DriverNode<GasNode, drivers::Some<drivers::GasDriver>, drivers::Effects> {
 public:
  explicit GasNode(const Experiment& experiment);

  using DriverNode::on;
  void on(const gas_command_t&, Time now, Outbox&);
  void on_measured(const drivers::GasFlows&, Time now, Outbox&);
};

std::unique_ptr<Node> make_gas(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
