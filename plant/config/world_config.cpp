#include "plant/config/world_config.h"

#include <cmath>
#include <stdexcept>

#include "plant/config/range.h"

namespace firn::plant {

DropletParams droplet413() {
  DropletParams p;
  p.cap_radius_mm = p.film_radius_mm = 0.2065;
  p.film_share = 0.0;
  p.fine_cells = 5;  // at 3 the radius is 2.4 fine cells, and the footprint's outline a staircase
  p.radius_exponent = 1.0 / 3.0;
  return p;
}

void check(const WorldConfig& c) { c.kind->check(c); }

void check_inkjet(const WorldConfig& c) {
  firn::check(c.grid);
  const DropletParams& d = c.droplet;
  require_within("droplet.volume_mm3", d.volume_mm3, 1e-9, 1.0);
  require_within("droplet.fine_cells", d.fine_cells, 1, 8);
  const double pitch_mm = c.grid.pitch_x_mm < c.grid.pitch_y_mm ? c.grid.pitch_x_mm : c.grid.pitch_y_mm;
  const double largest_mm = 14.0 * pitch_mm / d.fine_cells;  // Field's window is at most 40 fine cells wide
  require_within("droplet.flow", d.flow, 0.5, 2.0);
  require_within("droplet.spread", d.spread, 0.75, 1.5);
  require_within("droplet.radius_exponent", d.radius_exponent, 0.0, 1.0);
  const double wider = d.spread * std::pow(d.flow, d.radius_exponent);
  require_within("droplet.cap_radius_mm", wider * d.cap_radius_mm, 0.5 * pitch_mm, largest_mm);
  require_within("droplet.film_radius_mm", wider * d.film_radius_mm, 0.5 * pitch_mm, largest_mm);
  require_within("droplet.film_share", d.film_share, 0.0, 1.0);
  require_within("droplet.slope_bias_mm", d.slope_bias_mm, 1e-4, 1e6);
  require_within("droplet.levelling", d.levelling, 0.0, 0.25);
  require_within("droplet.run_share", d.run_share, 0.0, 0.25);
  require_within("droplet.levelling_steps", d.levelling_steps, 0, 20);
  require_within("droplet.cure_shrink", d.cure_shrink, 0.0, 0.5);
  require_within("droplet.margin_cells", d.margin_cells, 2, 50);
  require_within("droplet.size_scatter", d.size_scatter, 0.0, 0.5);
  require_within("droplet.placement_scatter_mm", d.placement_scatter_mm, 0.0, 10.0);
  require_within("droplet.missed_probability", d.missed_probability, 0.0, 1.0);
  require_within("droplet.satellite_probability", d.satellite_probability, 0.0, 1.0);
  require_within("droplet.satellite_share", d.satellite_share, 0.0, 0.9);
  require_within("nozzle.step_s", c.nozzle.step_s, 0.01, 1e4);
  require_within("nozzle.wander_sigma", c.nozzle.wander_sigma, 0.0, 1.0);
  require_within("nozzle.wander_memory", c.nozzle.wander_memory, 0.0, 1.0);
  require_within("lu2015.variation", c.lu2015.variation, 0.0, 1.0);
  require_within("nozzle_b_x_mm", c.nozzle_b_x_mm, -1000.0, 1000.0);
  require_within("nozzle_b_y_mm", c.nozzle_b_y_mm, -1000.0, 1000.0);
  require_within("ratio_b", c.ratio_b, 0.01, 100.0);
  require_within("sensor.noise_mm", c.sensor.noise_mm, 0.0, 1.0);
  require_within("sensor.dropout_floor", c.sensor.dropout_floor, 0.0, 1.0);
  require_within("profiler.points", c.profiler.points, c.profiler.point ? 1 : 2, 800);
  require_within("profiler.dx_mm", c.profiler.dx_mm, 0.0, 10.0);
  require_within("stage.counts_per_mm", c.stage.counts_per_mm, 1.0, 1e7);
  require_within("stage.scurve_percent", c.stage.scurve_percent, 0.0, 100.0);
  require_within("stage.ramp_rate_mm_s2", c.stage.ramp_rate_mm_s2, 1.0, 1e6);
  require_within("jet_b.max_rate_hz", c.jet_b.max_rate_hz, 1.0, 30'000.0);
  require_within("jet_b.baud", c.jet_b.baud, 300, 1e6);
  require_within("jet.max_rate_hz", c.jet.max_rate_hz, 1.0, 30'000.0);
  require_within("jet.baud", c.jet.baud, 300, 1e6);
  const StrobeParams& s = c.strobe;
  require_within("strobe.speed_m_s", s.speed_m_s, 0.01, 100.0);
  require_within("strobe.um_per_px", s.um_per_px, 0.1, 100.0);
  require_within("strobe.width_px", s.width_px, 64, 4096);
  require_within("strobe.height_px", s.height_px, 64, 4096);
  require_within("strobe.satellites", s.satellites, 0, 4);
  require_within("strobe.dirt", s.dirt, 0, 100);
  require_within("strobe.nozzle_gap_mm", s.nozzle_gap_mm, 0.0, 100.0);
  require_within("lamp.baud", c.lamp.baud, 300, 1e6);
  check_options("sensor", kSensorOptions, c.sensor);
  check_options("nozzle_faults", kNozzleFaults, c.nozzle_faults);
  check_options("stage_faults", kStageFaults, c.stage_faults);
  for_each_nature(c.nature, [&](std::string_view name, const auto& own, const auto& table) {
    if (name == c.model) check_options(name, table, own);
  });
  const NatureName* nature = nature_name(c.model);
  if (!nature && !c.model.starts_with("python:")) {
    std::string known;
    for (const NatureName& n : kNatureNames) known += std::string(n.name) + ", ";
    throw std::invalid_argument("world: model = \"" + c.model + "\" is not one of " + known +
                                "python:FILE.py:CLASS");
  }
  if (nature && c.two_inks && !nature->two_inks)
    throw std::invalid_argument("world: model = \"" + c.model + "\" has one ink");
}

}  // namespace firn::plant
