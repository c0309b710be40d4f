#include "procs/lamp/node.h"

#include "config/device_kinds.h"
#include "drivers/lamp/lamp.h"
#include "drivers/lamp/script_lamp.h"

namespace firn {
namespace {

using SomeLamp = drivers::Some<drivers::LampDriver>;

std::unique_ptr<drivers::LampDriver> lamp_driver(const Experiment& e) {
  drivers::LampOptions c{e.lamp};
  c.host_latency_s = host_latency_s(e.run.time_scale);
  if (is_python_driver(e, "lamp"))
    return std::make_unique<drivers::ScriptLamp>(script_options(e, "lamp", c.host_latency_s), c);
  return std::make_unique<drivers::Lamp>(c);
}

}  // namespace

LampNode::LampNode(const Experiment& e) : DriverNode(NodeId::kLamp, lamp_driver(e)) {
  subscribe(channels::kLampCommand, this);
  subscribe(channels::kRunEnd, this);
  subscribe(channels::device_state(NodeId::kStage), this);
}

void LampNode::on(const lamp_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  commanded_us_ = c.header.utime_us;
  bar(now, out);
  perform(c, false, now, out, [&](SomeLamp& lamp, std::int64_t now_us, Effects& fx) {
    lamp->expose(c.exposure_s, c.iris_percent, now_us, fx);
  });
}

void LampNode::on(const run_end_t& m, Time now, Outbox& out) {
  if (m.header.incarnation < incarnation()) return;  // a stop's, delivered only at the resume
  act(now, out,
      [&](SomeLamp& lamp, std::int64_t now_us, drivers::Effects& fx) { lamp->release(now_us, fx); });
}

void LampNode::on(const device_state_t& m, Time now, Outbox& out) {
  if (m.header.incarnation < incarnation() || m.header.seq < stage_seq_) return;  // a newer one overtook it
  stage_seq_ = m.header.seq;
  moves_us_ = DeviceState(m.state) == DeviceState::kActive ? m.header.utime_us : kRests;
  bar(now, out);
}

// The scheduler commands an exposure when the stage has answered that it is parked. A motion that was told
// before that has ended, though the state that told its end was lost.
void LampNode::bar(Time now, Outbox& out) {
  const bool moves = moves_us_ != kRests && moves_us_ >= commanded_us_;
  act(now, out, [&](SomeLamp& lamp, std::int64_t now_us, drivers::Effects& fx) {
    lamp->bar(moves ? "the stage is not at the cure pose: it moves" : "", now_us, fx);
  });
}

std::unique_ptr<Node> make_lamp(const std::string& config_toml, const Blobs&) {
  return std::make_unique<LampNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
