#include "plant/setup.h"

#include <algorithm>

namespace firn::plant {

WorldConfig world_config(const Experiment& e) {
  WorldConfig c;
  c.grid = e.grid;
  c.seed = e.plant.seed;
  c.model = e.plant.model;
  c.droplet.size_scatter = e.plant.size_std;
  c.droplet.placement_scatter_mm = e.plant.placement_std_mm;
  c.droplet.missed_probability = e.plant.missed_fraction;
  c.droplet.satellite_probability = e.plant.satellite_fraction;
  c.nozzle.wander_sigma = e.plant.drift;
  c.nozzle.drift = e.plant.drift > 0.0;
  c.lu2015.variation = e.plant.variation;
  c.two_inks = has_two_jets(e);
  c.nozzle_b_x_mm = e.plant.nozzle_b_x_mm;
  c.nozzle_b_y_mm = e.plant.nozzle_b_y_mm;
  c.ratio_b = e.plant.ratio_b;
  c.sensor.noise_mm = e.plant.sensor_noise_mm;
  c.sensor.dropout_floor = e.plant.dropout_fraction;
  c.stage.counts_per_mm = e.stage.counts_per_mm;
  c.stage.low_limit_mm = {e.stage.x_min_mm, e.stage.y_min_mm, e.stage.z_min_mm};
  c.stage.high_limit_mm = {e.stage.x_max_mm, e.stage.y_max_mm, e.stage.z_max_mm};
  c.stage.max_speed_mm_s = e.stage.max_speed_mm_s;
  c.stage.abort_rate_mm_s2 = std::max(c.stage.abort_rate_mm_s2, e.stage.acceleration_mm_s2);
  c.jet.max_rate_hz = e.jet.max_rate_hz;
  c.jet_b.max_rate_hz = e.jet_b.drive.max_rate_hz;
  c.profiler.points = e.laser_profiler.points;
  c.profiler.dx_mm = e.laser_profiler.dx_mm;
  c.profiler.laser_offset_y_mm = e.laser_profiler.offset_y_mm;
  c.lamp.max_on_us = std::int64_t(e.lamp.max_on_s * 1e6);
  return c;
}

}  // namespace firn::plant
