#include "procs/laser_point/node.h"

namespace firn {

LaserPointNode::LaserPointNode(const Experiment& e)
    : DriverNode(NodeId::kLaserPoint,
                 drivers::LaserPointOptions{e.laser_point, host_latency_s(e.run.time_scale)}) {
  subscribe(channels::kLaserCommand, this);
}

void LaserPointNode::on(const laser_command_t& c, Time now, Outbox& out) {
  using drivers::Effects;
  using drivers::LaserPoint;
  const LaserVerb verb = LaserVerb(c.verb);
  perform(c, false, now, out, [&](LaserPoint& laser, std::int64_t now_us, Effects& fx) {
    if (verb == LaserVerb::kCollect) return laser.collect(now_us, fx);
    if (verb == LaserVerb::kReading) {
      reading_ = c;
      return laser.reading(now_us, fx);
    }
    laser.arm(c.material, c.samples, c.period_s, now_us, fx);
    if (laser.busy()) armed_ = c;  // it was not refused
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
