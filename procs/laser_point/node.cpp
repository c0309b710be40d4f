#include "procs/laser_point/node.h"

#include "config/device_kinds.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/laser_point/script_point.h"

namespace firn {
namespace {

std::unique_ptr<drivers::LaserPointDriver> point_driver(const Experiment& e) {
  const drivers::LaserPointOptions c{e.laser_point, host_latency_s(e.run.time_scale)};
  if (is_python_driver(e, "laser_point"))
    return std::make_unique<drivers::ScriptPoint>(script_options(e, "laser_point", c.host_latency_s), c);
  return std::make_unique<drivers::LaserPoint>(c);
}

}  // namespace

LaserPointNode::LaserPointNode(const Experiment& e) : DriverNode(NodeId::kLaserPoint, point_driver(e)) {
  subscribe(channels::kLaserCommand, this);
}

void LaserPointNode::on(const laser_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  const LaserVerb verb = LaserVerb(c.verb);
  perform(c, false, now, out, [&](auto& laser, std::int64_t now_us, Effects& fx) {
    if (verb == LaserVerb::kCollect) return laser->collect(now_us, fx);
    if (verb == LaserVerb::kReading) {
      reading_ = c;
      return laser->reading(now_us, fx);
    }
    laser->arm(c.material, c.samples, c.period_s, now_us, fx);
    if (laser->busy()) armed_ = c;  // it was not refused
  });
}

void LaserPointNode::on_measured(drivers::Samples& s, Time now, Outbox& out) {
  const bool single = s.period_s == 0.0;
  const laser_command_t& c = single ? reading_ : armed_;
  laser_samples_t m{};
  m.n = std::int32_t(s.z_mm.size());
  m.layer = c.layer;
  m.attempt = c.attempt;
  m.scan_id = c.scan_id;
  m.path = single ? 0 : c.path;
  m.index = c.index;
  m.count = c.count;
  m.material = c.material;
  m.sample_utime_us = now.us;
  m.period_s = s.period_s;
  m.distance_mm = std::move(s.z_mm);
  out.send(channels::kLaserSamples, std::move(m));
}

std::unique_ptr<Node> make_laser_point(const std::string& config_toml, const Blobs&) {
  return std::make_unique<LaserPointNode>(parse_recorded_experiment(config_toml, "experiment.toml"));
}

}  // namespace firn
