#include "procs/jet/node.h"

#include <cmath>

namespace firn {
namespace {

int whole_volts(const char* key, double v) {
  if (v != std::round(v))
    throw std::invalid_argument(std::string("jet.") + key + " = " + std::to_string(v) +
                                ": the JetDrive takes whole volts");
  return int(v);
}

drivers::JetConfig jet_config(const Experiment& e) {
  const JetConfig& j = e.jet;
  drivers::JetConfig c;
  c.frequency_hz = j.max_rate_hz;  // FULLFREQ also caps external triggers
  c.waveform.idle_v = whole_volts("idle_v", j.idle_v);
  c.waveform.dwell_v = whole_volts("dwell_v", j.dwell_v);
  c.waveform.echo_v = whole_volts("echo_v", j.echo_v);
  c.waveform.rise_us = j.rise_us;
  c.waveform.dwell_us = j.dwell_us;
  c.waveform.fall_us = j.fall_us;
  c.waveform.echo_us = j.echo_us;
  c.waveform.final_us = j.final_us;
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

}  // namespace

JetNode::JetNode(const Experiment& e) : DriverNode(NodeId::kJet, jet_config(e)) {
  subscribe(channels::kJetCommand, this);
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
  return std::make_unique<JetNode>(parse_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
