#include "procs/thermometer/node.h"

#include "firn/bed_temperature_t.hpp"

namespace firn {
namespace {

drivers::ThermometerOptions thermometer_options(const Experiment& e) {
  return {e.thermometer, host_latency_s(e.run.time_scale)};
}

}  // namespace

ThermometerNode::ThermometerNode(const Experiment& e)
    : DriverNode(NodeId::kThermometer, thermometer_options(e)) {}

void ThermometerNode::on_measured(const drivers::BedTemperature& t, Time now, Outbox& out) {
  bed_temperature_t m{};
  m.sample_utime_us = now.us;
  m.degC = t.celsius;
  out.send(channels::kBedTemperature, std::move(m));
}

std::unique_ptr<Node> make_thermometer(const std::string& config_toml, const Blobs&) {
  return std::make_unique<ThermometerNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
