#include "procs/jet/node.h"

#include <cmath>

namespace firn {
namespace {

int whole_volts(NodeId id, const char* key, double v) {
  if (v != std::round(v))
    throw std::invalid_argument(std::string(info(id).name) + "." + key + " = " + std::to_string(v) +
                                ": the JetDrive takes whole volts");
  return int(v);
}

drivers::JetOptions jet_config(NodeId id, const Experiment& e) {
  const JetConfig& j = id == NodeId::kJetB ? e.jet_b.drive : e.jet;
  drivers::JetOptions c;
  c.frequency_hz = j.max_rate_hz;  // FULLFREQ also caps external triggers
  c.waveform.idle_v = whole_volts(id, "idle_v", j.idle_v);
  c.waveform.dwell_v = whole_volts(id, "dwell_v", j.dwell_v);
  c.waveform.echo_v = whole_volts(id, "echo_v", j.echo_v);
  c.waveform.rise_us = j.rise_us;
  c.waveform.dwell_us = j.dwell_us;
  c.waveform.fall_us = j.fall_us;
  c.waveform.echo_us = j.echo_us;
  c.waveform.final_us = j.final_us;
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
  return std::make_unique<JetNode>(NodeId::kJet, parse_experiment(config_toml, "experiment.toml"));
}

std::unique_ptr<Node> make_jet_b(const std::string& config_toml, const Blobs&) {
  return std::make_unique<JetNode>(NodeId::kJetB, parse_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
