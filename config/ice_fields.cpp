// The fields of the ice lab, and the selection of fields by kind of lab.
#include <algorithm>
#include <span>

#include "config/field_rows.h"
#include "config/labs.h"
#include "core/control/surface/surface_controller.h"
#include "core/deposition/valve.h"

namespace firn {
using namespace field_rows;

namespace {

Limits lab_names() {
  std::vector<std::string_view> names;
  for (const LabKind* lab : lab_kinds()) names.push_back(lab->name);
  return one_of(names);
}

std::string_view kinds_in_words() {
  static const std::string text = [] {
    std::string s = "which lab";
    for (const LabKind* lab : lab_kinds())
      s += (lab == lab_kinds().front() ? ": " : ", or ") + std::string(lab->meaning);
    return s;
  }();
  return text;
}

Table part_of(Experiment& e) {
  IceConfig& c = e.ice;
  return {
      {"lab.kind", &e.lab.kind, "", lab_names(), kinds_in_words()},
      {"ice.mesh", &c.mesh, "", path(), "part: STL, PLY, OBJ or 3MF, path relative to this file"},
      {"ice.slice", &c.slice, "", path(),
       "settings of firn slice, path relative to this file; layer height and measurement paths are "
       "[ice]'s"},
      {"ice.paths", &c.paths, "", path(),
       "instead of ice.mesh and ice.slice: a path file of firn slice, path relative to this file"},
      {"ice.machine", &c.machine, "", path(), "machine of firn plan, path relative to this file"},
      {"ice.height_mm", &c.height_mm, "mm", within(0, 1000), "layers above are left out; 0 = the whole mesh"},
      {"ice.origin_x_mm", &c.origin_x_mm, "mm", within(-1000, 1000),
       "of the part's frame in the robot's base frame"},
      {"ice.origin_y_mm", &c.origin_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"ice.origin_z_mm", &c.origin_z_mm, "mm", within(-1000, 1000),
       "joint 3 where the nozzle touches the table"},
      {"ice.interval_layers", &c.interval_layers, "layers", within(1, 100),
       "n_d: deposited between two measurements [Barnett, 5.1.3]"},
      {"ice.layer_height_mm", &c.layer_height_mm, "mm", above(0.01, 10), "nominal height of a layer"},
      {"ice.pitch_mm", &c.pitch_mm, "mm", above(0.05, 100), "of the interval's maps"},
      {"ice.measure_spacing_mm", &c.measure_spacing_mm, "mm", above(0.1, 100), "between measurement paths"},
      {"ice.measure_offset_mm", &c.measure_offset_mm, "mm", within(0, 100),
       "of measurement paths from the edge of their material; 0 = as its first bead"},
      {"ice.map_samples", &c.map_samples, "", within(1, 8),
       "a map cell's height is the mean over n x n places of it; 1 = the height at its centre"},
      {"ice.map_table", &c.map_table, "", one_of({"off", "on"}),
       "on: the bare table is measured before the first layer, along the paths that measure the first "
       "interval, and the first interval answers that map"},
      {"ice.coverage", &c.coverage, "", one_of({"window", "off"}),
       "window: flows make up for beads of a layer that overlap or leave spots, by means over 5 mm; off: as "
       "the widths say"},
      {"ice.water_boundary_mm_s", &c.water.boundary_mm_s, "mm/s", above(0, 1000),
       "nominal speed of water boundary paths; the motion limits may lower it"},
      {"ice.water_fill_mm_s", &c.water.fill_mm_s, "mm/s", above(0, 1000),
       "nominal speed of water fill paths"},
      {"ice.water_measure_mm_s", &c.water.measure_mm_s, "mm/s", above(0, 1000),
       "speed of measuring ice; its errors grow with it [5.2.1]"},
      {"ice.scaffold_boundary_mm_s", &c.scaffold.boundary_mm_s, "mm/s", above(0, 1000),
       "nominal speed of scaffold boundary paths"},
      {"ice.scaffold_fill_mm_s", &c.scaffold.fill_mm_s, "mm/s", above(0, 1000),
       "nominal speed of scaffold fill paths"},
      {"ice.scaffold_measure_mm_s", &c.scaffold.measure_mm_s, "mm/s", above(0, 1000),
       "speed of measuring scaffold"},
      {"ice.nozzle_gap_mm", &c.nozzle_gap_mm, "mm", above(0, 100), "nozzle above the nominal surface"},
      {"ice.clearance_mm", &c.clearance_mm, "mm", within(0, 100),
       "least height of the nozzle above the newest map; a path with less is run higher or refused (I6)"},
      {"ice.hop_mm", &c.hop_mm, "mm", within(0, 200), "how much higher the nozzle travels between paths"},
      row("ice.max_saturated_intervals", c.max_saturated_intervals, control::kSurfaceStopAfter),
      row("ice.saturated_share", c.saturated_share, control::kSurfaceStopShare),
      {"ice.least_rise_share", &c.least_rise_share, "", within(0, 1),
       "of what an interval deposits: a material that rose by less has an empty tank or a blocked line, "
       "which stops the print; 0 = never"},
      {"ice.max_time_slip_s", &c.max_time_slip_s, "s", above(0, 10),
       "between a path's planned and measured duration (I7)"},
      {"ice.max_pulses", &c.max_pulses, "", within(1, 16384),
       "of one list; a path with more is run in pieces"},
  };
}

Table valve(ValveLineConfig& v, const std::string& section) {
  Table t = rows(section, v, drivers::kValveDriveConfig);
  add(t, {
             {section + "hz_per_mm3_s", &v.hz_per_mm3_s, "Hz s/mm^3", deposition::kFrequencyPerFlow,
              "pulses per volume [(5.14)]; used while the table is empty"},
             {section + "table_hz", &v.table_hz, "Hz", within(0, 1000),
              "frequencies of the calibrated flow curve nu = h(Q), ascending [Fig. 6-1]"},
             {section + "table_mm3_s", &v.table_mm3_s, "mm^3/s", within(0, 10000), "their flows"},
         });
  return t;
}

Table instrument_table(Experiment& e) {
  Table t = rows("robot.", e.robot, drivers::kRobotConfig);
  add(t, valve(e.valve_a, "valve_a."));
  add(t, valve(e.valve_b, "valve_b."));
  add(t, rows("laser_point.", e.laser_point, drivers::kLaserPointConfig));
  add(t, rows("heater.", e.heater, drivers::kHeaterConfig));
  add(t, {
             {"flow.feed_forward", &e.flow.feed_forward, "", or_own(one_of({"off", "on"})),
              "on: the flow that flow_estimator has learned takes the place of the calibrated curve"},
         });
  return t;
}

Table calibration(CalibrationConfig& c) {
  return {
      {"calibration.jig_x_mm", &c.jig_x_mm, "mm", within(-1000, 1000),
       "low corner of the block that firn calibrate has laid on the table, in the part's frame"},
      {"calibration.jig_y_mm", &c.jig_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"calibration.jig_width_mm", &c.jig_width_mm, "mm", within(1, 500), "its size along x, as gauged"},
      {"calibration.jig_depth_mm", &c.jig_depth_mm, "mm", within(1, 500), "its size along y"},
      {"calibration.jig_height_mm", &c.jig_height_mm, "mm", within(0.1, 100), "its height"},
      {"calibration.table_x_mm", &c.table_x_mm, "mm", within(-1000, 1000),
       "the levelling table's middle, in the part's frame: feet at its corners, nine screws 3 x 3 over it "
       "[2.2]"},
      {"calibration.table_y_mm", &c.table_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"calibration.table_width_mm", &c.table_width_mm, "mm", within(10, 10000), "its size along x"},
      {"calibration.table_depth_mm", &c.table_depth_mm, "mm", within(10, 10000), "its size along y"},
      {"calibration.foot_pitch_mm", &c.foot_pitch_mm, "mm", within(0.05, 20),
       "lift of a foot per turn clockwise"},
      {"calibration.screw_pitch_mm", &c.screw_pitch_mm, "mm", within(0.05, 20),
       "lift of a screw per turn clockwise"},
      {"calibration.level_x_mm", &c.level_x_mm, "mm", within(-1000, 1000),
       "columns of the points at which the table's height is measured, in the part's frame"},
      {"calibration.level_y_mm", &c.level_y_mm, "mm", within(-1000, 1000), "and their rows"},
      {"calibration.cup_x_mm", &c.cup_x_mm, "mm", within(-1000, 1000),
       "where the cup for weighing stands, in the part's frame"},
      {"calibration.cup_y_mm", &c.cup_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"calibration.density_water_mg_mm3", &c.density_water_mg_mm3, "mg/mm^3", within(0.1, 10),
       "of printed water: makes volumes of weights"},
      {"calibration.density_sme_mg_mm3", &c.density_sme_mg_mm3, "mg/mm^3", within(0.1, 10),
       "of printed scaffold"},
  };
}

bool within_any(std::string_view key, std::span<const std::string_view> prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](std::string_view p) {
    return key == p || (p.ends_with('.') && key.starts_with(p));
  });
}

}  // namespace

std::vector<Field> ice_fields(Experiment& e) {
  Table t = part_of(e);
  add(t, instrument_table(e));
  add(t, calibration(e.calibration));
  return t;
}

std::vector<Field> ice_plant_fields(Experiment& e) {
  IcePlantConfig& p = e.plant.ice;
  return {
      {"plant.ice.field_x0_mm", &p.field_x0_mm, "mm", within(-1000, 1000),
       "low corner of the simulated surface, in the part's frame"},
      {"plant.ice.field_y0_mm", &p.field_y0_mm, "mm", within(-1000, 1000), "the same along y"},
      {"plant.ice.field_width_mm", &p.field_width_mm, "mm", zero_or(5, 500),
       "its size along x; 0 = firn print puts it round all paths"},
      {"plant.ice.field_depth_mm", &p.field_depth_mm, "mm", zero_or(5, 500), "the same along y"},
      {"plant.ice.cell_mm", &p.cell_mm, "mm", within(0.15, 0.6), "cells of the simulated surface"},
      {"plant.ice.drift_water", &p.drift_water, "", within(-0.3, 0.3),
       "relative change of the water's flow in the end"},
      {"plant.ice.drift_sme", &p.drift_sme, "", within(-0.3, 0.3),
       "relative change of the scaffold's flow in the end"},
      {"plant.ice.drift_spread", &p.drift_spread, "", within(0, 0.3),
       "each valve's change has one more share, drawn evenly between minus and plus this by plant.seed and "
       "valve"},
      {"plant.ice.origin_dx_mm", &p.origin_dx_mm, "mm", within(-20, 20),
       "where the part's frame truly stands, beyond ice.origin_x_mm"},
      {"plant.ice.origin_dy_mm", &p.origin_dy_mm, "mm", within(-20, 20), "the same along y"},
      {"plant.ice.origin_dz_mm", &p.origin_dz_mm, "mm", within(-20, 20), "the same along z"},
      {"plant.ice.laser_dx_mm", &p.laser_dx_mm, "mm", within(-20, 20),
       "where the laser's spot truly is, beyond the machine's tool_laser"},
      {"plant.ice.laser_dy_mm", &p.laser_dy_mm, "mm", within(-20, 20), "the same along y"},
      {"plant.ice.laser_dz_mm", &p.laser_dz_mm, "mm", within(-5, 5), "the same along z"},
      {"plant.ice.valve_a_dx_mm", &p.valve_a_dx_mm, "mm", within(-20, 20),
       "where the water nozzle truly is, beyond the machine's tool_water"},
      {"plant.ice.valve_a_dy_mm", &p.valve_a_dy_mm, "mm", within(-20, 20), "the same along y"},
      {"plant.ice.valve_b_dx_mm", &p.valve_b_dx_mm, "mm", within(-20, 20),
       "where the scaffold nozzle truly is, beyond the machine's tool_scaffold"},
      {"plant.ice.valve_b_dy_mm", &p.valve_b_dy_mm, "mm", within(-20, 20), "the same along y"},
      {"plant.ice.tank_water_mm3", &p.tank_water_mm3, "mm^3", within(0, 1e9), "water in the tank"},
      {"plant.ice.tank_sme_mm3", &p.tank_sme_mm3, "mm^3", within(0, 1e9), "scaffold material in the tank"},
      {"plant.ice.debris_per_h", &p.debris_per_h, "1/h", within(0, 1000), "bumps that fall on the part"},
      {"plant.ice.roughness", &p.roughness, "", within(0, 1),
       "share of each layer's height that freezes rough, new in every layer [FIT: the floor of Fig. 5-9]"},
      {"plant.ice.foot_mm", &p.foot_mm, "mm", within(-10, 10),
       "levelling table: heights of its four feet; empty = level"},
      {"plant.ice.screw_mm", &p.screw_mm, "mm", within(-10, 10),
       "and of its nine screws, row by row; empty = level"},
      {"plant.ice.table_x_mm", &p.table_x_mm, "mm", within(-1000, 1000),
       "the table's middle, in the part's frame"},
      {"plant.ice.table_y_mm", &p.table_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"plant.ice.table_width_mm", &p.table_width_mm, "mm", within(10, 10000), "its size along x"},
      {"plant.ice.table_depth_mm", &p.table_depth_mm, "mm", within(10, 10000), "its size along y"},
      {"plant.ice.table_roughness_mm", &p.table_roughness_mm, "mm", within(0, 5),
       "its fixed unevenness, standard deviation"},
      {"plant.ice.jig_mm", &p.jig_mm, "mm", within(-1000, 1000),
       "blocks on it: x0, y0, x1, y1 and height of each, at most 16"},
      {"plant.ice.start_delay_s", &p.start_delay_s, "s", within(0, 0.1),
       "from the robot's signal to its motion"},
      {"plant.ice.laser_delay_s", &p.laser_delay_s, "s", within(0, 0.1),
       "from the signal to the laser's first stored reading"},
      {"plant.ice.valve_a_delay_s", &p.valve_a_delay_s, "s", within(0, 0.05),
       "from a pulse's tick to the middle of its liquid, water"},
      {"plant.ice.valve_b_delay_s", &p.valve_b_delay_s, "s", within(0, 0.05), "the same of the scaffold"},
      {"plant.ice.flow_water_mm3_s", &p.flow_water_mm3_s, "mm^3/s", within(10, 250),
       "through the open valve, water"},
      {"plant.ice.flow_sme_mm3_s", &p.flow_sme_mm3_s, "mm^3/s", within(10, 250), "the same of the scaffold"},
      {"plant.ice.recovery_water", &p.recovery_water, "", within(0, 0.9),
       "a pulse right after another is shorter by this share, water [Fig. 6-1]"},
      {"plant.ice.recovery_sme", &p.recovery_sme, "", within(0, 0.9), "the same of the scaffold"},
      {"plant.ice.balance_std_mg", &p.balance_std_mg, "mg", within(0, 1000),
       "standard deviation of a weighing"},
      {"plant.ice.instruments", &p.instruments, "", one_of({"protocols", "programs"}),
       "simulated robot and valves: written from their protocols, or executing the robot's V+ text and the "
       "valves' firmware"},
  };
}

bool belongs(const Field& f, std::string_view kind) {
  const LabKind& lab = lab_kind(kind);
  return within_any(f.key, lab.keys) && !within_any(f.key, lab.without);
}

}  // namespace firn
