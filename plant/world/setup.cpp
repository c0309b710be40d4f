#include "plant/world/setup.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include "config/device_kinds.h"
#include "config/machine.h"
#include "core/control/python_scheme.h"
#include "core/grid/random.h"
#include "plant/inkjet/python_model.h"
#include "plant/inkjet/strobe_scene.h"
#include "plant/twins/pulse_response.h"
#include "plant/twins/vplus_text.h"
#include "plant/world/aerosol_lab.h"
#include "python/host/recorded_files.h"

namespace firn::plant {
namespace {

IceTool shifted(const ToolConfig& tool, double dx_mm, double dy_mm, double dz_mm) {
  return {tool.x_mm + dx_mm, tool.y_mm + dy_mm, tool.z_mm + dz_mm};
}

constexpr std::uint32_t kDriftDraw = 3;  // 1, 2 and 7 are debris and the table

double drift_of(const Experiment& e, std::uint32_t valve) {
  const IcePlantConfig& p = e.plant.ice;
  const double share =
      2.0 * random_uniform({e.plant.seed, Purpose::kDisturbance, kDriftDraw, valve, 0}) - 1.0;
  return std::clamp((valve == 0 ? p.drift_water : p.drift_sme) + p.drift_spread * share, -0.3, 0.3);
}

// The thesis's tools lie at the places of its Table 3-1, except where the experiment plants others.
IceWorldConfig ice_config(const Experiment& e) {
  IceWorldConfig c;
  const IcePlantConfig& p = e.plant.ice;
  const Machine machine;
  if (p.field_width_mm != 0.0 || p.field_depth_mm != 0.0)
    c.field = {p.cell_mm, p.field_x0_mm, p.field_y0_mm, p.field_width_mm, p.field_depth_mm};
  c.field.cell_mm = p.cell_mm;
  c.line[0].drift = drift_of(e, 0);
  c.line[1].drift = drift_of(e, 1);
  c.line[0].tank_mm3 = p.tank_water_mm3;
  c.line[1].tank_mm3 = p.tank_sme_mm3;
  c.arm.origin_mm = {e.ice.origin_x_mm + p.origin_dx_mm, e.ice.origin_y_mm + p.origin_dy_mm,
                     e.ice.origin_z_mm + p.origin_dz_mm};
  c.arm.valve_a = shifted(machine.water, p.valve_a_dx_mm, p.valve_a_dy_mm, 0.0);
  c.arm.valve_b = shifted(machine.scaffold, p.valve_b_dx_mm, p.valve_b_dy_mm, 0.0);
  c.arm.laser = shifted(machine.laser, p.laser_dx_mm, p.laser_dy_mm, p.laser_dz_mm);
  c.disturbance.debris_per_h = p.debris_per_h;
  c.disturbance.roughness = p.roughness;
  c.balance.std_mg = p.balance_std_mg;
  if (p.instruments == "programs") {
    c.robot.texts = vplus_texts();
    for (IceValveParams& v : c.valve) v.firmware = true;
  }
  c.arm.start_delay_s = p.start_delay_s;
  c.laser.trigger_delay_s = p.laser_delay_s;
  c.line[0].open_delay_s = p.valve_a_delay_s;
  c.line[1].open_delay_s = p.valve_b_delay_s;
  c.line[0].full_flow_mm3_s = p.flow_water_mm3_s;
  c.line[1].full_flow_mm3_s = p.flow_sme_mm3_s;
  c.line[0].recovery_share = p.recovery_water;
  c.line[1].recovery_share = p.recovery_sme;
  c.table.centre_x_mm = p.table_x_mm;
  c.table.centre_y_mm = p.table_y_mm;
  c.table.width_mm = p.table_width_mm;
  c.table.depth_mm = p.table_depth_mm;
  c.table.roughness_mm = p.table_roughness_mm;
  for (std::size_t n = 0; n + 5 <= p.jig_mm.size(); n += 5)
    c.table.jigs.push_back({p.jig_mm[n], p.jig_mm[n + 1], p.jig_mm[n + 2], p.jig_mm[n + 3], p.jig_mm[n + 4]});
  std::copy_n(p.foot_mm.begin(), std::min(p.foot_mm.size(), c.table.foot_mm.size()), c.table.foot_mm.begin());
  std::copy_n(p.screw_mm.begin(), std::min(p.screw_mm.size(), c.table.screw_mm.size()),
              c.table.screw_mm.begin());
  return c;
}

JetPulse pulse_of(const JetConfig& j) { return {j.dwell_us, j.rise_us, j.fall_us, j.dwell_v - j.idle_v}; }

void set_up_jet(const JetConfig& j, bool volume_by_pulse, JetParams& p) {
  p.volume_by_pulse = volume_by_pulse;
  p.max_rate_hz = j.max_rate_hz;
  p.kind = drivers::kJetKindWords[std::size_t(j.kind)];
  p.trigger_on = j.trigger_on;
  p.trigger_off = j.trigger_off;
}

StrobeParams strobe_of(const Experiment& e) {
  const PlantCameraConfig& p = e.plant.camera;
  StrobeParams s;
  if (p.drop_speed_m_s > 0.0) {
    s.speed_m_s = p.drop_speed_m_s;
    s.nozzle_gap_mm = e.process.nozzle_gap_mm;
  }
  s.angle_deg = p.drop_angle_deg;
  s.jitter_us = p.drop_jitter_us;
  s.break_off_us = p.break_off_us;
  s.satellites = p.satellites;
  s.um_per_px = p.um_per_px;
  s.nozzle_um = p.nozzle_um;
  s.width_px = p.width_px;
  s.height_px = p.height_px;
  s.blur_px = p.blur_px;
  s.noise = p.noise;
  s.light = p.light;
  s.uneven = p.uneven;
  s.dirt = p.dirt;
  s.dead_before = p.dead_before;
  s.best_dwell_us = p.best_dwell_us;
  s.threshold_v = p.threshold_v;
  return s;
}

void set_up_ice(const Experiment& e, WorldConfig& c) { c.ice = ice_config(e); }

constexpr double kSecondsPerHour = 3600.0;
constexpr std::int64_t kSettle_us = 20'000;  // of the aerosol lab's stage after a move

// The machine's flow is what the lab believes; the nozzle's own share of it is the plant's.
void set_up_aerosol(const Experiment& e, WorldConfig& c) {
  const AerosolPlantConfig& p = e.plant.aerosol;
  AerosolParams a;
  a.flow_mm3_s = e.aerosol.flow_mm3_s;
  a.solids = e.aerosol.solids;
  a.flow = p.flow;
  const double drawn = 2.0 * random_uniform({e.plant.seed, Purpose::kDisturbance, 41, 0, 0}) - 1.0;
  a.drift = p.drift + (drawn < 0.0 ? -p.drift_spread : p.drift_spread);
  a.drift_s = p.drift_s;
  a.wander = p.wander;
  a.clog_per_h = p.clog_per_h;
  a.vial_s = p.vial_h * kSecondsPerHour;
  a.level_loss = p.level_loss;
  a.tube_per_h = p.tube_per_h;
  a.open_delay_s = p.open_delay_s;
  a.close_delay_s = p.close_delay_s;
  a.tail_s = p.tail_s;
  a.blob_s = p.blob_s;
  a.nozzle_mm = p.nozzle_mm;
  a.focusing_ratio = p.focusing_ratio;
  a.overspray = p.overspray;
  a.halo = p.halo;
  a.optical_depth_mm = p.optical_depth_mm;
  a.camera_x_mm = e.aerosol.camera_x_mm + p.camera_dx_mm;
  a.camera_y_mm = e.aerosol.camera_y_mm + p.camera_dy_mm;
  a.camera_turn = p.camera_turn_deg * std::numbers::pi / 180.0;
  a.gas = on(e.gas.use);
  c.stage.servo_hz = p.servo_hz;
  c.stage.servo_damping = p.servo_damping;
  c.stage.servo_feed_forward = p.servo_feed_forward;
  c.stage.settle_us = kSettle_us;
  AerosolWorldConfig own{a, {}};
  own.gas.units = e.gas.atomizer_unit + e.gas.sheath_unit;  // they are set up as the lab file says
  own.gas.gas = e.gas.gas;
  c.own = own;
}

/// Holds a lab's world and its configuration beyond the common part; nullptr: no such part.
struct WorldSetup {
  std::string_view lab;  ///< lab.kind
  const WorldKind* kind;
  void (*set_up)(const Experiment&, WorldConfig&);
};
constexpr WorldSetup kWorlds[] = {
    {"inkjet", &kInkjetWorld, nullptr},
    {"ice", &kIceWorld, &set_up_ice},
    {"aerosol", &kAerosolWorld, &set_up_aerosol},
};

}  // namespace

WorldConfig world_config(const Experiment& e) {
  WorldConfig c;
  const auto world = std::ranges::find(kWorlds, std::string_view(e.lab.kind), &WorldSetup::lab);
  if (world == std::end(kWorlds))
    throw std::invalid_argument("lab.kind = \"" + e.lab.kind + "\": no world is simulated for it");
  c.kind = world->kind;
  if (world->set_up) world->set_up(e, c);
  c.grid = e.grid;
  c.seed = e.plant.seed;
  c.host_scale = e.run.time_scale;
  c.model = e.plant.model;
  if (e.plant.droplet == "droplet413") c.droplet = droplet413();
  c.droplet.slope_bias_mm = e.plant.slope_bias_mm;
  c.droplet.flow = e.plant.flow;
  c.droplet.spread = e.plant.spread;
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
  c.nature = e.plant.nature;
  static_cast<SensorOptions&>(c.sensor) = e.plant.faults.sensor;
  c.nozzle_faults = e.plant.faults.nozzle;
  c.stage_faults = e.plant.faults.stage;
  c.sensor.noise_mm = e.plant.sensor_noise_mm;
  c.sensor.dropout_floor = e.plant.dropout_fraction;
  c.stage.counts_per_mm = e.stage.counts_per_mm;
  c.stage.low_limit_mm = {e.stage.x_min_mm, e.stage.y_min_mm, e.stage.z_min_mm};
  c.stage.high_limit_mm = {e.stage.x_max_mm, e.stage.y_max_mm, e.stage.z_max_mm};
  c.stage.max_speed_mm_s = e.stage.max_speed_mm_s;
  c.stage.terminal_needed = true;
  if (has_grbl_stage(e)) {
    c.stage.kind = "grbl";
    c.stage.laser_output = on(e.stage.laser_output);
    c.stage.box_pitch_mm = on(e.stage.scan_box)
                               ? std::round(e.grid.pitch_y_mm * e.stage.counts_per_mm) / e.stage.counts_per_mm
                               : 0.0;
    c.stage.ramp_rate_mm_s2 = e.stage.acceleration_mm_s2;  // $120, which no host sets
  }
  c.stage.abort_rate_mm_s2 = std::max(c.stage.abort_rate_mm_s2, e.stage.acceleration_mm_s2);
  const bool by_pulse = e.actuation.small_share > 0.0;
  set_up_jet(e.jet, by_pulse, c.jet);
  set_up_jet(e.jet_b.drive, by_pulse, c.jet_b);
  c.profiler.points = e.laser_profiler.points;
  c.profiler.dx_mm = e.laser_profiler.dx_mm;
  c.profiler.laser_offset_y_mm = e.laser_profiler.offset_y_mm;
  c.profiler.head_x_mm = e.laser_profiler.offset_x_mm;  // it hangs as the lab file says
  c.profiler.mirrored = on(e.laser_profiler.mirror_x);
  c.profiler.upside_down = e.laser_profiler.z_sign == drivers::ZSign::kDown;
  c.profiler.zero_mm = e.laser_profiler.z_zero_mm;
  if (has_point_scan(e)) {
    c.profiler.point = true;
    c.profiler.points = 1;
    c.profiler.dx_mm = e.grid.pitch_x_mm;
    c.profiler.laser_offset_x_mm = e.laser_profiler.offset_x_mm;
  }
  c.profiler.error_x_mm = e.plant.profiler_dx_mm;
  c.profiler.error_y_mm = e.plant.profiler_dy_mm;
  c.profiler.error_z_mm = e.plant.profiler_dz_mm;
  c.strobe = strobe_of(e);
  c.droplet.flight_time_s = fall_s(c, jet_speed_m_s(c.strobe, pulse_of(e.jet)));
  c.lamp.max_on_us = std::int64_t(e.lamp.max_on_s * 1e6);
  return c;
}

WorldConfig world_config(const Experiment& e, const Blobs& inputs) {
  WorldConfig c = world_config(e);
  if (!is_python_model(c.model)) return c;
  const control::PythonScheme scheme = control::parse_python_scheme(c.model);
  c.own = PythonNature{python::recorded_files(inputs, python::kPlantRole, scheme.file_name()),
                       {scheme.class_name, scheme.arguments}};
  return c;
}

}  // namespace firn::plant
