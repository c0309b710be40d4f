#include "procs/valve/node.h"

namespace firn {
namespace {

drivers::ValveOptions valve_config(NodeId id, const Experiment& e) {
  const ValveLineConfig& v = id == NodeId::kValveB ? e.valve_b : e.valve_a;
  drivers::ValveOptions c{v};
  c.valve = int(id == NodeId::kValveB ? ValveId::kB : ValveId::kA);
  c.host_latency_s = host_latency_s(e.run.time_scale);
  return c;
}

}  // namespace

ValveNode::ValveNode(NodeId id, const Experiment& e)
    : DriverNode(id, valve_config(id, e)), valve_(int(id == NodeId::kValveB ? ValveId::kB : ValveId::kA)) {
  subscribe(channels::kPulseList, this);
  subscribe(id == NodeId::kValveB ? channels::kValveBCommand : channels::kValveACommand, this);
}

void ValveNode::on(const pulse_list_t& m, Time now, Outbox& out) {
  if (m.valve != valve_) return;
  act(now, out, [&](drivers::Valve& valve, std::int64_t now_us, drivers::Effects& fx) {
    valve.add_list({m.path, m.list}, m.tick_s, m.pulse_s, m.tick, now_us, fx);
  });
}

void ValveNode::on(const valve_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  const ValveVerb verb = ValveVerb(c.verb);
  perform(c, verb == ValveVerb::kArm, now, out, [&](drivers::Valve& valve, std::int64_t now_us, Effects& fx) {
    if (verb == ValveVerb::kLoad)
      valve.load({c.path, c.list}, now_us, fx);
    else if (verb == ValveVerb::kArm)
      valve.arm({c.path, c.list}, now_us, fx);
    else
      valve.disarm(now_us, fx);
  });
}

std::unique_ptr<Node> make_valve_a(const std::string& config_toml, const Blobs&) {
  return std::make_unique<ValveNode>(NodeId::kValveA,
                                     parse_recorded_experiment(config_toml, "experiment.toml"));
}

std::unique_ptr<Node> make_valve_b(const std::string& config_toml, const Blobs&) {
  return std::make_unique<ValveNode>(NodeId::kValveB,
                                     parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
