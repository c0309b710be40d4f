#include "procs/jet/node.h"

#include <cmath>
#include <utility>

#include "config/device_kinds.h"
#include "drivers/jet/script_jet.h"

namespace firn {
namespace {

const JetConfig& drive(NodeId id, const Experiment& e) { return id == NodeId::kJetB ? e.jet_b.drive : e.jet; }

drivers::JetOptions jet_config(NodeId id, const Experiment& e) {
  const JetConfig& j = drive(id, e);
  for (const auto& [key, volts] : {std::pair{"idle_v", j.idle_v},
                                   {"dwell_v", j.dwell_v},
                                   {"echo_v", j.echo_v},
                                   {"small_dwell_v", j.small_dwell_v},
                                   {"small_echo_v", j.small_echo_v}})
    if (volts != std::round(volts))
      throw std::invalid_argument(std::string(info(id).name) + "." + key + " = " + std::to_string(volts) +
                                  ": the jet takes whole volts");
  drivers::JetOptions c{j};  // max_rate_hz becomes FULLFREQ, which also caps external triggers
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

std::unique_ptr<drivers::JetInterface> jet_driver(NodeId id, const Experiment& e) {
  const std::string_view node = info(id).name;
  if (is_python_driver(e, node))
    return std::make_unique<drivers::ScriptJet>(script_options(e, node, host_latency_s(e.run.time_scale)));
  return drivers::make_jet(jet_config(id, e));
}

std::unique_ptr<Node> make(NodeId id, const std::string& config_toml) {
  return std::make_unique<JetNode>(id, parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace

JetNode::JetNode(NodeId id, const Experiment& e) : DriverNode(id, jet_driver(id, e)) {
  subscribe(id == NodeId::kJetB ? channels::kJetBCommand : channels::kJetCommand, this);
}

void JetNode::on(const jet_command_t& c, Time now, Outbox& out) {
  const JetVerb verb = JetVerb(c.verb);
  perform(c, false, now, out, [&](drivers::SomeJet& some, std::int64_t now_us, drivers::Effects& fx) {
    drivers::JetInterface& jet = *some;
    switch (verb) {
      case JetVerb::kArm:
        return jet.arm(c.expected, now_us, fx);
      case JetVerb::kArmSmall:
        return jet.arm_small(c.expected, now_us, fx);
      case JetVerb::kDisarm:
        return jet.disarm(now_us, fx);
      case JetVerb::kJet:
        return jet.jet(now_us, fx);
    }
  });
}

std::unique_ptr<Node> make_jet(const std::string& config_toml, const Blobs&) {
  return make(NodeId::kJet, config_toml);
}

std::unique_ptr<Node> make_jet_b(const std::string& config_toml, const Blobs&) {
  return make(NodeId::kJetB, config_toml);
}

}  // namespace firn
