#include "plant/config/world_config.h"

#include <stdexcept>

namespace firn::plant {
namespace {

void range(const char* field, double value, double low, double high) {
  if (!(value >= low && value <= high))
    throw std::invalid_argument(std::string("world: ") + field + " = " + std::to_string(value) +
                                " is outside " + std::to_string(low) + " .. " + std::to_string(high));
}

}  // namespace

void check(const WorldConfig& c) {
  if (c.kind != "inkjet" && c.kind != "ice")
    throw std::invalid_argument("world: kind = \"" + c.kind + "\" is not one of inkjet, ice");
  if (c.kind == "ice") return check(c.ice);
  firn::check(c.grid);
  const DropletParams& d = c.droplet;
  range("droplet.volume_mm3", d.volume_mm3, 1e-9, 1.0);
  range("droplet.fine_cells", d.fine_cells, 1, 8);
  const double pitch_mm = c.grid.pitch_x_mm < c.grid.pitch_y_mm ? c.grid.pitch_x_mm : c.grid.pitch_y_mm;
  const double largest_mm = 14.0 * pitch_mm / d.fine_cells;  // Field's window is at most 40 fine cells wide
  range("droplet.cap_radius_mm", d.cap_radius_mm, 0.5 * pitch_mm, largest_mm);
  range("droplet.film_radius_mm", d.film_radius_mm, 0.5 * pitch_mm, largest_mm);
  range("droplet.film_share", d.film_share, 0.0, 1.0);
  range("droplet.slope_bias_mm", d.slope_bias_mm, 1e-4, 1e6);
  range("droplet.levelling", d.levelling, 0.0, 0.25);
  range("droplet.run_share", d.run_share, 0.0, 0.25);
  range("droplet.levelling_steps", d.levelling_steps, 0, 20);
  range("droplet.cure_shrink", d.cure_shrink, 0.0, 0.5);
  range("droplet.margin_cells", d.margin_cells, 2, 50);
  range("droplet.size_scatter", d.size_scatter, 0.0, 0.5);
  range("droplet.placement_scatter_mm", d.placement_scatter_mm, 0.0, 10.0);
  range("droplet.missed_probability", d.missed_probability, 0.0, 1.0);
  range("droplet.satellite_probability", d.satellite_probability, 0.0, 1.0);
  range("droplet.satellite_share", d.satellite_share, 0.0, 0.9);
  range("nozzle.step_s", c.nozzle.step_s, 0.01, 1e4);
  range("nozzle.wander_sigma", c.nozzle.wander_sigma, 0.0, 1.0);
  range("nozzle.wander_memory", c.nozzle.wander_memory, 0.0, 1.0);
  range("lu2015.variation", c.lu2015.variation, 0.0, 1.0);
  range("nozzle_b_x_mm", c.nozzle_b_x_mm, -1000.0, 1000.0);
  range("nozzle_b_y_mm", c.nozzle_b_y_mm, -1000.0, 1000.0);
  range("ratio_b", c.ratio_b, 0.01, 100.0);
  range("sensor.noise_mm", c.sensor.noise_mm, 0.0, 1.0);
  range("sensor.dropout_floor", c.sensor.dropout_floor, 0.0, 1.0);
  range("profiler.points", c.profiler.points, 2, 800);
  range("profiler.dx_mm", c.profiler.dx_mm, 0.0, 10.0);
  range("stage.counts_per_mm", c.stage.counts_per_mm, 1.0, 1e7);
  range("stage.ramp_rate_mm_s2", c.stage.ramp_rate_mm_s2, 1.0, 1e6);
  range("jet_b.max_rate_hz", c.jet_b.max_rate_hz, 1.0, 30'000.0);
  range("jet_b.baud", c.jet_b.baud, 300, 1e6);
  range("jet.max_rate_hz", c.jet.max_rate_hz, 1.0, 30'000.0);
  range("jet.baud", c.jet.baud, 300, 1e6);
  range("lamp.baud", c.lamp.baud, 300, 1e6);
  if (c.model != "droplets" && c.model != "lu2015")
    throw std::invalid_argument("world: model = \"" + c.model + "\" is not one of droplets, lu2015");
}

}  // namespace firn::plant
