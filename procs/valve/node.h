// ValveNode connects a valve to the bus, valve_a or valve_b: VALVE_A_COMMAND, VALVE_B_COMMAND, PULSE_LIST,
// ENABLE, SAFE_STOP, instrument -> ANSWER_VALVE_A, STATE_VALVE_A, FAULT_VALVE_A, …
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/valve/valve.h"
#include "firn/pulse_list_t.hpp"
#include "firn/valve_command_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/valve: the water's valve (kValveA) or the scaffold's (kValveB). Lists are sent to the
/// valve's controller on arrival. ANSWER of a disarm: counted = pulses fired of expected, also after a stop
/// or a lost link.
class ValveNode final : public DriverNode<ValveNode, drivers::Valve, drivers::Effects> {
 public:
  ValveNode(NodeId id, const Experiment& experiment);

  using DriverNode::on;
  void on(const pulse_list_t&, Time now, Outbox&);
  void on(const valve_command_t&, Time now, Outbox&);

 private:
  int valve_;  // of pulse_list_t
};

std::unique_ptr<Node> make_valve_a(const std::string& config_toml, const Blobs& blobs);
std::unique_ptr<Node> make_valve_b(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
