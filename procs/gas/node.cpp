#include "procs/gas/node.h"

#include "config/device_kinds.h"
#include "drivers/gas/gas.h"
#include "drivers/gas/script_gas.h"

namespace firn {
namespace {

std::unique_ptr<drivers::GasDriver> gas_driver(const Experiment& e) {
  const drivers::GasOptions c{e.gas, host_latency_s(e.run.time_scale)};
  if (is_python_driver(e, "gas"))
    return std::make_unique<drivers::ScriptGas>(script_options(e, "gas", c.host_latency_s), c);
  return std::make_unique<drivers::Gas>(c);
}

}  // namespace

GasNode::GasNode(const Experiment& e) : DriverNode(NodeId::kGas, gas_driver(e)) {
  subscribe(channels::kGasCommand, this);
}

void GasNode::on(const gas_command_t& c, Time now, Outbox& out) {
  perform(c, false, now, out, [&](auto& gas, std::int64_t now_us, drivers::Effects& fx) {
    gas->set(c.atomizer_sccm, c.sheath_sccm, now_us, fx);
  });
}

void GasNode::on_measured(const drivers::GasFlows& f, Time now, Outbox& out) {
  gas_flow_t m{};
  m.sample_utime_us = now.us;
  for (std::size_t n = 0; n < 2; ++n) {
    m.sccm[n] = f.sccm[n];
    m.set_sccm[n] = f.set_sccm[n];
    m.pressure_kPa[n] = f.kpa[n];
    m.degC[n] = f.celsius[n];
    m.fault[n] = std::int8_t(f.fault[n]);
  }
  m.steady = f.steady;
  out.send(channels::kGasFlow, std::move(m));
}

std::unique_ptr<Node> make_gas(const std::string& config_toml, const Blobs&) {
  return std::make_unique<GasNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
