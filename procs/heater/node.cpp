#include "procs/heater/node.h"

#include <algorithm>

#include "config/device_kinds.h"
#include "drivers/heater/heater.h"
#include "drivers/heater/script_heater.h"

namespace firn {
namespace {

std::unique_ptr<drivers::HeaterDriver> heater_driver(const Experiment& e) {
  drivers::HeaterOptions c{e.heater};
  c.host_latency_s = host_latency_s(e.run.time_scale);
  if (is_python_driver(e, "heater"))
    return std::make_unique<drivers::ScriptHeater>(script_options(e, "heater", c.host_latency_s), c);
  return std::make_unique<drivers::Heater>(c);
}

}  // namespace

HeaterNode::HeaterNode(const Experiment& e) : DriverNode(NodeId::kHeater, heater_driver(e)) {
  subscribe(channels::kHeaterCommand, this);
}

void HeaterNode::on(const heater_command_t& c, Time now, Outbox& out) {
  perform(c, false, now, out, [&](auto& heater, std::int64_t now_us, drivers::Effects& fx) {
    heater->set({c.set_degC[0], c.set_degC[1], c.set_degC[2]}, now_us, fx);
  });
}

void HeaterNode::on_measured(const drivers::Temperatures& t, Time now, Outbox& out) {
  temperature_t m{};
  m.sample_utime_us = now.us;
  std::copy(t.celsius.begin(), t.celsius.end(), m.degC);
  std::copy(t.set_celsius.begin(), t.set_celsius.end(), m.set_degC);
  std::copy(t.fault.begin(), t.fault.end(), m.fault);
  out.send(channels::kTemperature, std::move(m));
}

std::unique_ptr<Node> make_heater(const std::string& config_toml, const Blobs&) {
  return std::make_unique<HeaterNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
