// JetNode connects a jet to the bus, jet or jet_b: JET_COMMAND, JET_B_COMMAND, ENABLE, SAFE_STOP, instrument
// -> ANSWER_JET, STATE_JET, FAULT_JET, …
#pragma once

#include <memory>
#include <string>

#include "config/experiment.h"
#include "drivers/jet/jet_kinds.h"
#include "firn/jet_command_t.hpp"
#include "runtime/driver_node.h"

namespace firn {

/// Adapter of drivers/jet: arm for external triggers, disarm. The jet of ink A (kJet) or that of ink B
/// (kJetB), of the kind that its settings name.
class JetNode final : public DriverNode<JetNode, drivers::SomeJet, drivers::Effects> {
 public:
  /// @throws std::invalid_argument for a waveform beyond the limits.
  JetNode(NodeId id, const Experiment& experiment);

  using DriverNode::on;
  void on(const jet_command_t&, Time now, Outbox&);
};

std::unique_ptr<Node> make_jet(const std::string& config_toml, const Blobs& blobs);
std::unique_ptr<Node> make_jet_b(const std::string& config_toml, const Blobs& blobs);

}  // namespace firn
