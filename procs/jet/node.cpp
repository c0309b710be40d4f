#include "procs/jet/node.h"

#include <cmath>
#include <utility>

namespace firn {
namespace {

drivers::JetOptions jet_config(NodeId id, const Experiment& e) {
  const JetConfig& j = id == NodeId::kJetB ? e.jet_b.drive : e.jet;
  for (const auto& [key, volts] :
       {std::pair{"idle_v", j.idle_v}, {"dwell_v", j.dwell_v}, {"echo_v", j.echo_v}})
    if (volts != std::round(volts))
      throw std::invalid_argument(std::string(info(id).name) + "." + key + " = " + std::to_string(volts) +
                                  ": the JetDrive takes whole volts");
  drivers::JetOptions c{j};  // max_rate_hz becomes FULLFREQ, which also caps external triggers
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

}  // namespace

JetNode::JetNode(NodeId id, const Experiment& e) : DriverNode(id, jet_config(id, e)) {
  subscribe(id == NodeId::kJetB ? channels::kJetBCommand : channels::kJetCommand, this);
}

void JetNode::on(const jet_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  using drivers::Jet;
  const JetVerb verb = JetVerb(c.verb);
  perform(c, false, now, out, [&](Jet& jet, std::int64_t now_us, Effects& fx) {
    if (verb == JetVerb::kArm)
      jet.arm(c.expected, now_us, fx);
    else
      jet.disarm(now_us, fx);
  });
}

std::unique_ptr<Node> make_jet(const std::string& config_toml, const Blobs&) {
  return std::make_unique<JetNode>(NodeId::kJet, parse_recorded_experiment(config_toml, "experiment.toml"));
}

std::unique_ptr<Node> make_jet_b(const std::string& config_toml, const Blobs&) {
  return std::make_unique<JetNode>(NodeId::kJetB, parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
