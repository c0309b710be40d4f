#include "plant/config/ice_config.h"

#include <string>

#include "plant/config/range.h"

namespace firn::plant {
namespace {

void range(const std::string& field, double value, double low, double high) {
  require_within("ice." + field, value, low, high);
}

void check_line(const std::string& at, const IceLineParams& l) {
  range(at + "tank_pressure_kpa", l.tank_pressure_kpa, 1.0, 500.0);
  range(at + "nozzle_mm", l.nozzle_mm, 0.05, 1.0);
  range(at + "viscosity_40c_mm2_s", l.viscosity_40c_mm2_s, 0.1, 100.0);
  range(at + "viscosity_b_K", l.viscosity_b_K, 0.0, 10000.0);
  range(at + "density_kg_m3", l.density_kg_m3, 500.0, 2000.0);
  range(at + "discharge", l.discharge, 0.3, 1.0);
  range(at + "full_flow_mm3_s", l.full_flow_mm3_s, 10.0, 250.0);
  range(at + "line_drop", l.line_drop, 0.0, 0.5);
  range(at + "line_tau_s", l.line_tau_s, 0.001, 10.0);
  range(at + "recovery_share", l.recovery_share, 0.0, 0.9);
  range(at + "recovery_tau_s", l.recovery_tau_s, 1e-4, 0.1);
  range(at + "open_delay_s", l.open_delay_s, 0.0, 0.05);
  range(at + "coil_gain", l.coil_gain, 0.0, 0.5);
  range(at + "coil_tau_s", l.coil_tau_s, 1.0, 1e4);
  range(at + "drift", l.drift, -0.3, 0.3);
  range(at + "drift_tau_s", l.drift_tau_s, 1.0, 1e6);
  range(at + "pulsation", l.pulsation, 0.0, 0.3);
  range(at + "pulsation_tau_s", l.pulsation_tau_s, 0.01, 1000.0);
  range(at + "tank_mm3", l.tank_mm3, 0.0, 1e9);
}

void check_bead(const std::string& at, const IceBeadParams& b) {
  range(at + "pool_mm", b.pool_mm, 0.05, 1.0);
  range(at + "deepest_mm", b.deepest_mm, 0.05, 2.0);
  range(at + "edge_mm", b.edge_mm, 0.1, 5.0);
  range(at + "spill", b.spill, 0.0, 3.0);
  range(at + "scatter_mm", b.scatter_mm, 0.0, 2.0);
  range(at + "wander_rad", b.wander_rad, 0.0, 0.3);
  range(at + "wander_tau_s", b.wander_tau_s, 0.01, 100.0);
}

void check_heat(const IceHeatParams& h) {
  range("heat.ambient_degC", h.ambient_degC, -60.0, 30.0);
  for (std::size_t n = 0; n < 3; ++n) {
    const std::string at = "[" + std::to_string(n) + "]";
    range("heat.capacity_J_K" + at, h.capacity_J_K[n], 1.0, 1e5);
    range("heat.loss_W_K" + at, h.loss_W_K[n], 0.0, 100.0);
    range("heat.heater_W" + at, h.heater_W[n], 0.0, 1000.0);
    range("heat.set_degC" + at, h.set_degC[n], 0.0, 45.0);
  }
  for (const double g : h.link_W_K) range("heat.link_W_K", g, 0.0, 100.0);
  range("heat.hysteresis_K", h.hysteresis_K, 0.1, 10.0);
  range("heat.valve_J_per_pulse", h.valve_J_per_pulse, 0.0, 1.0);
  range("heat.freeze_degC", h.freeze_degC, -60.0, 40.0);
  range("heat.freeze_sme_degC", h.freeze_sme_degC, -60.0, 40.0);
  range("heat.start_degC", h.start_degC, -60.0, 60.0);
}

void check_arm(const IceArmParams& a) {
  range("arm.link_1_mm", a.link_1_mm, 10.0, 5000.0);
  range("arm.link_2_mm", a.link_2_mm, 10.0, 5000.0);
  range("arm.servo_hz", a.servo_hz, 2.0, 100.0);
  range("arm.servo_damping", a.servo_damping, 0.3, 2.0);
  range("arm.cantilever_hz", a.cantilever_hz, 3.0, 60.0);
  range("arm.cantilever_damping", a.cantilever_damping, 0.001, 0.5);
  range("arm.start_delay_s", a.start_delay_s, 0.0, 0.1);
  range("arm.start_jitter_s", a.start_jitter_s, 0.0, 0.05);
  range("arm.clock_ppm", a.clock_ppm, -1000.0, 1000.0);
  range("arm.slip_probability", a.slip_probability, 0.0, 1.0);
  range("arm.slip_s", a.slip_s, 0.0, 10.0);
  range("arm.brake_s", a.brake_s, 0.016, 5.0);
  for (std::size_t n = 0; n < 4; ++n) {
    range("arm.encoder", a.encoder[n], 1e-9, 10.0);
    range("arm.high", a.high[n], a.low[n], 1e4);
  }
}

void check_laser(const IceLaserParams& l) {
  range("laser.baud", l.baud, 300, 1e6);
  range("laser.range_mm", l.range_mm, 0.1, 100.0);
  range("laser.repeatability_mm", l.repeatability_mm, 0.0, 1.0);
  range("laser.linearity", l.linearity, 0.0, 0.1);
  range("laser.trigger_delay_s", l.trigger_delay_s, 0.0, 0.1);
  range("laser.clock_ppm", l.clock_ppm, -1000.0, 1000.0);
  for (const double noise : {l.ice_noise_mm, l.scaffold_noise_mm, l.wrong_noise_mm})
    range("laser.noise_mm", noise, 0.0, 5.0);
  for (const double share : {l.ice_dropout, l.scaffold_dropout, l.wrong_dropout})
    range("laser.dropout", share, 0.0, 1.0);
  range("laser.speed_power", l.speed_power, 0.0, 5.0);
  range("laser.slope_dropout", l.slope_dropout, 0.0, 10.0);
}

}  // namespace

IceWorldConfig::IceWorldConfig() {
  line[1].tank_pressure_kpa = 97.0;
  line[1].nozzle_mm = 0.254;
  line[1].viscosity_40c_mm2_s = 4.7;
  line[1].viscosity_b_K = 2145.0;
  line[1].density_kg_m3 = 875.0;
  bead[1].deepest_mm = 0.30;
  bead[1].spill = 1.20;
  bead[1].scatter_mm = 0.15;
}

void make_steady(IceWorldConfig& c) {
  for (IceLineParams& line : c.line) line.viscosity_b_K = line.coil_gain = line.drift = line.pulsation = 0.0;
  for (IceBeadParams& bead : c.bead) bead.wander_tau_s = 0.01;  // of its range: nothing is left after a pause
  c.disturbance.debris_per_h = 0.0;
  c.arm.servo_hz = 100.0;  // the stiffest and most damped of their ranges: the arm stands where it was sent
  c.arm.cantilever_hz = 60.0;
  c.arm.cantilever_damping = 0.5;
}

void check(const IceWorldConfig& c) {
  range("field.cell_mm", c.field.cell_mm, 0.15, 0.6);
  range("field.width_mm", c.field.width_mm, 5.0, 500.0);
  range("field.height_mm", c.field.height_mm, 5.0, 500.0);
  range("field.x0_mm", c.field.x0_mm, -1000.0, 1000.0);
  range("field.y0_mm", c.field.y0_mm, -1000.0, 1000.0);
  for (std::size_t n = 0; n < 2; ++n) {
    const std::string at = "[" + std::to_string(n) + "].";
    check_bead("bead" + at, c.bead[n]);
    check_line("line" + at, c.line[n]);
    range("valve" + at + "baud", c.valve[n].baud, 300, 1e6);
    range("valve" + at + "clock_ppm", c.valve[n].clock_ppm, -1000.0, 1000.0);
    range("valve" + at + "trigger_delay_s", c.valve[n].trigger_delay_s, 0.0, 0.1);
  }
  check_heat(c.heat);
  check_arm(c.arm);
  check_laser(c.laser);
  range("table.centre_x_mm", c.table.centre_x_mm, -1000.0, 1000.0);
  range("table.centre_y_mm", c.table.centre_y_mm, -1000.0, 1000.0);
  for (const double foot : c.table.foot_mm) range("table.foot_mm", foot, -10.0, 10.0);
  for (const double screw : c.table.screw_mm) range("table.screw_mm", screw, -10.0, 10.0);
  for (const IceJig& jig : c.table.jigs)
    for (const double v : {jig.x0_mm, jig.y0_mm, jig.x1_mm, jig.y1_mm, jig.top_mm})
      range("table.jigs", v, -1000.0, 1000.0);
  range("table.width_mm", c.table.width_mm, 10.0, 1e4);
  range("table.depth_mm", c.table.depth_mm, 10.0, 1e4);
  range("table.roughness_mm", c.table.roughness_mm, 0.0, 5.0);
  range("table.jigs", double(c.table.jigs.size()), 0.0, 16.0);
  for (const double density : c.balance.density_mg_mm3) range("balance.density_mg_mm3", density, 0.1, 10.0);
  range("balance.std_mg", c.balance.std_mg, 0.0, 1000.0);
  range("balance.step_mg", c.balance.step_mg, 0.001, 1000.0);
  const IceDisturbanceParams& d = c.disturbance;
  range("disturbance.debris_per_h", d.debris_per_h, 0.0, 1000.0);
  range("disturbance.debris_height_mm", d.debris_height_mm, 0.0, 5.0);
  range("disturbance.debris_radius_mm", d.debris_radius_mm, 0.1, 10.0);
  range("disturbance.pattern", d.pattern, 0.0, 0.2);
  range("disturbance.pattern_mm", d.pattern_mm, 2.0, 500.0);
  range("disturbance.roughness", d.roughness, 0.0, 1.0);
  range("disturbance.roughness_mm", d.roughness_mm, 0.5, 100.0);
  range("disturbance.gap_mm", d.gap_mm, 0.1, 50.0);
}

}  // namespace firn::plant
