// thermometer: ENABLE, SAFE_STOP, instrument -> BED_TEMPERATURE, STATE_THERMOMETER, FAULT_THERMOMETER.
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/thermometer/thermometer.h"
#include "runtime/driver_node.h"

namespace firn {

/// Sends a BED_TEMPERATURE for each reading of drivers/thermometer.
class ThermometerNode final : public DriverNode<ThermometerNode, drivers::Thermometer, drivers::Effects> {
 public:
  explicit ThermometerNode(const Experiment& experiment);

  void on_measured(const drivers::BedTemperature&, Time now, Outbox&);
};

std::unique_ptr<Node> make_thermometer(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
