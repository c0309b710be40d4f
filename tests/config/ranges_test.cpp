// Ties the range of every numeric key to the check of the configured object: at both bounds, on both sides.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "config/error.h"
#include "config/ice_lab.h"
#include "config/reader.h"
#include "core/control/lines/line_controller.h"
#include "core/control/surface/surface_controller.h"
#include "core/grid/solids.h"
#include "drivers/camera/camera.h"
#include "drivers/gas/gas.h"
#include "drivers/heater/heater.h"
#include "drivers/jet/jet.h"
#include "drivers/lamp/lamp.h"
#include "drivers/laser_point/laser_point.h"
#include "drivers/laser_profiler/laser_profiler.h"
#include "drivers/robot/robot.h"
#include "drivers/stage/stage.h"
#include "drivers/valve/valve.h"
#include "estimators/droplet/droplet_estimator.h"
#include "estimators/droplet/height_filter.h"
#include "plant/world/setup.h"
#include "procs/controller/node.h"
#include "tests/config/ranges.h"

using namespace firn;
using firn::test::Kind;
using firn::test::Probe;
using firn::test::tie;

namespace {

GridSpec small_grid() { return {6, 6, 0.26, 0.26, 0.0, 0.0}; }

void build_controller(Experiment& e, const char* scheme) {
  e.grid = small_grid();
  e.control.scheme = scheme;
  control::make_controller(control_setup(e, HeightMap(e.grid, 0.1), Mask(e.grid, 1)), control_options(e));
}

Probe<Experiment> controller(const char* keys, const char* scheme, const char* name = "") {
  return {keys, [=](Experiment& e) { build_controller(e, scheme); }, name};
}

Probe<Experiment> surface(const char* keys, const char* scheme, const char* name = "") {
  return {keys,
          [=](Experiment& e) {
            e.control.scheme = scheme;
            control::make_surface_controller(surface_options(e, 10));
          },
          name};
}

void build_lines(Experiment& e) {
  control::LineSetup setup;
  setup.job = {{0, -1}, {0, 2}, {{{0, 0}, {6, 0}, 3.0}}};
  setup.machine.axis = {4.0, 30.0};
  setup.options = e.aerosol;
  control::LineController{setup};
}

Probe<Experiment> model(const char* key, const char* name) {
  return {key,
          [](Experiment& e) {
            deposition::check(deposition::DropletModel{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm});
            deposition::check(deposition::DropletModel{e.model.g1_mm, e.model.g2_mm, e.model.g3_mm});
          },
          name};
}

Probe<Experiment> world(const char* keys, const char* name = "", const char* lab = "inkjet") {
  return {keys,
          [=](Experiment& e) {
            e.lab.kind = lab;
            IcePlantConfig& p = e.plant.ice;
            const bool placed = p.field_x0_mm != 0.0 || p.field_y0_mm != 0.0;
            if (p.field_width_mm == 0.0 && (placed || p.field_depth_mm != 0.0)) p.field_width_mm = 100.0;
            if (p.field_depth_mm == 0.0 && p.field_width_mm != 0.0) p.field_depth_mm = 100.0;
            plant::check(plant::world_config(e));
          },
          name};
}

/// The keys of one physics of the ink-jet lab.
Probe<Experiment> nature(const std::string& name) {
  Probe<Experiment> probe = world("");
  probe.keys = "plant." + name + ".";
  probe.build = [build = probe.build, name](Experiment& e) {
    e.plant.model = name;
    build(e);
  };
  return probe;
}

void build_estimator(Experiment& e) { droplet::DropletEstimator(small_grid(), e.estimator); }

/// A shape that does not use the size.
void build_shape(Experiment& e, const char* kind) {
  e.part.shape.kind = kind;
  e.part.shape.width_mm = e.part.shape.depth_mm = 10.0;
  check(e.part.shape);
}

/// The driver of the instrument, made with the settings of its section.
template <class Driver, class Options>
Probe<Experiment> instrument(const char* keys, Options options) {
  return {keys, [options](Experiment& e) { Driver{options(e)}; }};
}

drivers::JetOptions second_jet(Experiment& e) { return drivers::JetOptions{e.jet_b.drive}; }

Probe<Experiment> first_jet(const char* keys) {
  return instrument<drivers::Jet>(keys, [](Experiment& e) { return drivers::JetOptions{e.jet}; });
}

drivers::RobotOptions robot(Experiment& e) {
  drivers::RobotOptions options;
  static_cast<RobotConfig&>(options) = e.robot;
  return options;
}

Probe<Experiment> valve(const char* keys, ValveLineConfig Experiment::*line) {
  return instrument<drivers::Valve>(keys, [line](Experiment& e) { return drivers::ValveOptions{e.*line}; });
}

}  // namespace

TEST_CASE("Every numeric key of an experiment has the range of what it configures") {
  tie<Experiment>({
      [](Experiment& e) { return fields(e); },
      {
          {"grid.", [](Experiment& e) { check(e.grid); }},
          model("model.h1_mm", "h1"),
          model("model.h2_mm", "h2"),
          model("model.h3_mm", "h3"),
          model("model.g1_mm", "h1"),
          model("model.g2_mm", "h2"),
          model("model.g3_mm", "h3"),
          {"actuation.positions_", [](Experiment& e) { OffsetTable{e.actuation}; }},
          {"actuation.small_share", [](Experiment& e) { OffsetTable{e.actuation}; }},
          {"actuation.heights_mm",
           [](Experiment& e) {
             e.actuation.heights_mm.resize(50, 1e-3);
             deposition::offset_model({}, OffsetTable({OffsetKind::kX, 2, 1}), e.actuation.heights_mm);
           }},
          {"actuation.flow_range_mm",
           [](Experiment& e) {
             deposition::offset_model({}, OffsetTable({OffsetKind::kX, 2, 1}), {}, e.actuation.flow_range_mm);
           }},
          controller("control.max_layers", "smf"),
          controller("control.noise_gate", "mpc"),
          controller("control.stall_layers", "mpc"),
          controller("control.target_offset_mm", "mpc"),
          controller("control.open_loop.", "open_loop"),
          controller("control.smf.kp", "smf"),
          controller("control.smf.ki_star", "smf"),
          controller("control.smf.kd_star", "smf"),
          controller("control.smf.output_limit", "smf"),
          controller("control.smf.integral_limit", "smf"),
          controller("control.smf.layer_height_mm", "smf"),
          controller("control.smf.max_drops", "smf"),
          surface("control.smf.kp", "smf"),
          surface("control.smf.ki_star", "smf"),
          surface("control.smf.kd_star", "smf"),
          surface("control.smf.integral_limit", "smf"),
          surface("control.smf.speed_range", "smf"),
          surface("control.foresee.", "smf_foresee"),
          surface("control.extra.adaptive_", "smf_adaptive"),
          controller("control.extra.ilc_", "spatial_ilc"),
          controller("control.extra.graph_", "graph_mpc"),
          controller("control.threshold.", "threshold"),
          controller("control.rim_inset", "threshold"),
          controller("control.mpc.strip_rows", "mpc"),
          controller("control.mpc.sweeps", "mpc"),
          controller("control.mpc.gap", "mpc"),
          controller("control.mpc.anneal_sweeps", "mpc"),
          controller("control.mpc.horizon", "mpc"),
          controller("control.mpc.alpha", "mpc"),
          controller("control.mpc.subset", "mpc"),
          controller("control.mpc.max_evaluations", "mpc"),
          controller("control.mpc.max_drops", "mpc"),
          controller("control.mpc.finish_layers", "mpc"),
          controller("control.mpc.min_improvement_mm", "mpc"),
          controller("control.mpc.outside_price", "mpc"),
          controller("control.mpc.rise_layers", "mpc"),
          {"control.mpc.edge_lag_layers",
           [](Experiment& e) {
             e.control.mpc.rise_layers = 1.0;
             build_controller(e, "mpc");
           }},
          controller("control.pattern.layers", "pattern"),
          controller("control.pattern.fill", "pattern"),
          controller("control.pattern.spacing_cells", "pattern"),
          controller("control.pattern.largest_square", "pattern"),
          controller("control.pattern.square_step", "pattern"),
          controller("control.registration.", "registration"),
          {"control.droplet_scatter",
           [](Experiment& e) {
             droplet::HeightFilter(small_grid(),
                                   {{}, deposition::Border::kLose, e.control.filter.droplet_scatter});
           }},
          {"estimator.", build_estimator},
          surface("ice.max_saturated_intervals", "smf", "stop_after"),
          surface("ice.saturated_share", "smf", "stop_share"),
          world("stage.counts_per_mm"),
          world("jet.max_rate_hz"),
          world("jet_b.max_rate_hz"),
          world("laser_profiler.points"),
          world("laser_profiler.dx_mm"),
          world("plant.ratio_b"),
          world("plant.variation"),
          world("plant.slope_bias_mm", "droplet.slope_bias_mm"),
          world("plant.flow", "droplet.flow"),
          world("plant.spread", "droplet.spread"),
          world("plant.size_std", "size_scatter"),
          world("plant.placement_std_mm", "placement_scatter_mm"),
          world("plant.missed_fraction", "missed_probability"),
          world("plant.satellite_fraction", "satellite_probability"),
          world("plant.drift", "wander_sigma"),
          world("plant.nozzle_b_x_mm"),
          world("plant.nozzle_b_y_mm"),
          world("plant.sensor_noise_mm", "noise_mm"),
          world("plant.dropout_fraction", "dropout"),
          world("plant.sensor."),
          world("plant.nozzle."),
          world("plant.stage."),
          nature("wu_chiu"),
          nature("graph_flow"),
          nature("thin_film"),
          world("plant.aerosol.flow", "", "aerosol"),
          world("plant.aerosol.wander", "", "aerosol"),
          world("plant.aerosol.open_delay_s", "", "aerosol"),
          world("plant.aerosol.close_delay_s", "", "aerosol"),
          world("plant.aerosol.tail_s", "", "aerosol"),
          world("plant.aerosol.blob_s", "", "aerosol"),
          world("plant.aerosol.nozzle_mm", "", "aerosol"),
          world("plant.aerosol.focusing_ratio", "", "aerosol"),
          world("plant.aerosol.overspray", "", "aerosol"),
          world("plant.aerosol.halo", "", "aerosol"),
          world("plant.aerosol.clog_per_h", "", "aerosol"),
          world("plant.aerosol.vial_h", "", "aerosol"),
          world("plant.aerosol.level_loss", "", "aerosol"),
          world("plant.aerosol.tube_per_h", "", "aerosol"),
          world("plant.aerosol.optical_depth_mm", "", "aerosol"),
          world("plant.aerosol.camera_turn_deg", "camera_turn", "aerosol"),
          world("plant.aerosol.servo_", "", "aerosol"),
          world("aerosol.flow_mm3_s", "", "aerosol"),
          world("aerosol.solids", "", "aerosol"),
          world("plant.ice.field_x0_mm", "x0_mm", "ice"),
          world("plant.ice.field_y0_mm", "y0_mm", "ice"),
          world("plant.ice.field_width_mm", "field.width_mm", "ice"),
          world("plant.ice.field_depth_mm", "field.height_mm", "ice"),
          world("plant.ice.cell_mm", "", "ice"),
          world("plant.ice.tank_water_mm3", "tank_mm3", "ice"),
          world("plant.ice.tank_sme_mm3", "tank_mm3", "ice"),
          world("plant.ice.debris_per_h", "", "ice"),
          world("plant.ice.roughness", "disturbance.roughness", "ice"),
          world("plant.ice.table_width_mm", "table.width_mm", "ice"),
          world("plant.ice.table_depth_mm", "table.depth_mm", "ice"),
          world("plant.ice.table_roughness_mm", "table.roughness_mm", "ice"),
          world("plant.ice.start_delay_s", "", "ice"),
          world("plant.ice.laser_delay_s", "trigger_delay_s", "ice"),
          world("plant.ice.valve_a_delay_s", "open_delay_s", "ice"),
          world("plant.ice.valve_b_delay_s", "open_delay_s", "ice"),
          world("plant.ice.flow_water_mm3_s", "full_flow_mm3_s", "ice"),
          world("plant.ice.flow_sme_mm3_s", "full_flow_mm3_s", "ice"),
          world("plant.ice.recovery_water", "recovery_share", "ice"),
          world("plant.ice.recovery_sme", "recovery_share", "ice"),
          world("plant.ice.balance_std_mg", "balance.std_mg", "ice"),
          world("plant.ice.table_x_mm", "table.centre_x_mm", "ice"),
          world("plant.ice.table_y_mm", "table.centre_y_mm", "ice"),
          world("plant.ice.foot_mm", "table.foot_mm", "ice"),
          world("plant.ice.screw_mm", "table.screw_mm", "ice"),
          {"part.height_mm", [](Experiment& e) { build_shape(e, "cylinder"); }},
          {"part.diameter_mm", [](Experiment& e) { build_shape(e, "cuboid"); }},
          {"part.inner_diameter_mm", [](Experiment& e) { build_shape(e, "cuboid"); }},
          {"part.width_mm", [](Experiment& e) { check(e.part.shape); }},
          {"part.depth_mm", [](Experiment& e) { check(e.part.shape); }},
          {"part.low_height_mm", [](Experiment& e) { build_shape(e, "cuboid"); }},
          {"geometry.outer_diameter_mm", [](Experiment& e) { check(e.geometry.solid); }},
          {"geometry.inner_diameter_mm", [](Experiment& e) { check(e.geometry.solid); }},
          {"geometry.branch_", [](Experiment& e) { check(e.geometry.solid); }},
          {"geometry.centre_z_mm", [](Experiment& e) { check(e.geometry.solid); }},
          {"geometry.height_mm", [](Experiment& e) { check(e.geometry.solid); }},
          {"geometry.image_pitch_z_mm",
           [](Experiment& e) {
             ImageStack(small_grid(), e.geometry.image_pitch_z_mm, {Mask(small_grid(), 1)});
           }},
          controller("control.pattern.seed", "pattern"),
          instrument<drivers::Stage>("stage.", [](Experiment& e) { return drivers::StageOptions{e.stage}; }),
          instrument<drivers::Jet>("jet.", [](Experiment& e) { return drivers::JetOptions{e.jet}; }),
          instrument<drivers::Jet>("jet_b.dwell_", second_jet),
          instrument<drivers::Jet>("jet_b.echo_", second_jet),
          instrument<drivers::Jet>("jet_b.small_", second_jet),
          instrument<drivers::Jet>("jet_b.rise_", second_jet),
          instrument<drivers::Jet>("jet_b.fall_", second_jet),
          instrument<drivers::Jet>("jet_b.final_", second_jet),
          instrument<drivers::Jet>("jet_b.idle_", second_jet),
          instrument<drivers::Jet>("jet_b.max_rate_hz", second_jet),
          instrument<drivers::LaserProfiler>(
              "laser_profiler.",
              [](Experiment& e) { return drivers::LaserProfilerOptions{e.laser_profiler}; }),
          instrument<drivers::Lamp>("lamp.", [](Experiment& e) { return drivers::LampOptions{e.lamp}; }),
          instrument<drivers::Robot>("robot.", robot),
          valve("valve_a.pulse_us", &Experiment::valve_a),
          valve("valve_a.guard_us", &Experiment::valve_a),
          valve("valve_a.poll_", &Experiment::valve_a),
          valve("valve_a.latency_s", &Experiment::valve_a),
          valve("valve_b.pulse_us", &Experiment::valve_b),
          valve("valve_b.guard_us", &Experiment::valve_b),
          valve("valve_b.poll_", &Experiment::valve_b),
          valve("valve_b.latency_s", &Experiment::valve_b),
          instrument<drivers::LaserPoint>(
              "laser_point.", [](Experiment& e) { return drivers::LaserPointOptions{e.laser_point}; }),
          instrument<drivers::Heater>("heater.",
                                      [](Experiment& e) { return drivers::HeaterOptions{e.heater}; }),
          instrument<drivers::Gas>("gas.", [](Experiment& e) { return drivers::GasOptions{e.gas}; }),
          instrument<drivers::Gas>("devices.gas.dialect.",
                                   [](Experiment& e) { return drivers::GasOptions{e.gas}; }),
          instrument<drivers::Camera>("camera.",
                                      [](Experiment& e) { return drivers::CameraOptions{e.camera}; }),
          instrument<drivers::Stage>("devices.stage.dialect.",
                                     [](Experiment& e) { return drivers::StageOptions{e.stage}; }),
          first_jet("devices.jet.dialect.ack"),
          first_jet("devices.jet.dialect.nak"),
          first_jet("devices.jet.dialect.poll_"),
          first_jet("devices.jet.dialect.source_"),
          first_jet("devices.jet.dialect.strobe_"),
          first_jet("devices.jet.dialect.most_"),
          instrument<drivers::Robot>("devices.robot.dialect.", robot),
          valve("devices.valve_a.dialect.", &Experiment::valve_a),
          valve("devices.valve_b.dialect.", &Experiment::valve_b),
          instrument<drivers::LaserPoint>(
              "devices.laser_point.dialect.",
              [](Experiment& e) { return drivers::LaserPointOptions{e.laser_point}; }),
          {"aerosol.", build_lines},
          {"valve_a.hz_per_mm3_s", [](Experiment& e) { valve_setting(e.valve_a); }},
          {"valve_b.hz_per_mm3_s", [](Experiment& e) { valve_setting(e.valve_b); }},
      },
      {
          {"devices.jet.dialect.max_", "caps, which the waveform keeps"},
          {"devices.jet.dialect.command_at", "a place in a reply, by the reply's size"},
          {"devices.jet.dialect.status_at", "the same"},
          {"devices.jet.dialect.size", "that size"},
          {"devices.jet.dialect.version_size", "the same"},
          {"devices.jet_b.dialect.", "as devices.jet.dialect."},
          {"watch.", "a person's choices: the band of a jet, the sweeps of its watch"},
          {"plant.camera.", "the look of nature"},
          {"plant.aerosol.drift", "drawn together by seed"},
          {"plant.aerosol.camera_d", "a displacement of any size"},
          {"run.", "the run's own: clocks and folders"},
          {"bus.", "faults that the bus injects"},
          {"part.image_white_mm", "scale of a picture"},
          {"part.um_per_px", "scale of a picture"},
          {"part.mesh_", "scale of a mesh, which needs the mesh"},
          {"geometry.mesh_", "scale and place of a mesh, which need the mesh"},
          {"geometry.judge_above_layers", "a share of a layer, for which core takes any height"},
          {"control.smoothing", "a switch"},
          {"control.mpc.seed", "any number is a seed"},
          {"plant.seed", "any number is a seed"},
          {"process.", "what the scheduler commands"},
          {"jet_b.offset_", "where the lab believes the nozzle to be"},
          {"ice.height_mm", "how much of a mesh is printed"},
          {"ice.origin_", "where the part stands"},
          {"ice.interval_layers", "layers, of which core takes the height"},
          {"ice.layer_height_mm", "the same"},
          {"ice.pitch_mm", "grid of the maps, which needs the paths"},
          {"ice.measure_", "given to the settings of slicing"},
          {"ice.map_samples", "given to the map of scattered readings, which needs readings"},
          {"ice.water_", "nominal speeds, which the motion limits lower"},
          {"ice.scaffold_", "the same"},
          {"ice.nozzle_gap_mm", "heights of the nozzle"},
          {"ice.clearance_mm", "an interlock"},
          {"ice.hop_mm", "heights of the nozzle"},
          {"ice.least_rise_share", "an interlock"},
          {"process.least_rise_share", "an interlock"},
          {"process.most_rise_share", "an interlock"},
          {"process.most_beside_share", "an interlock"},
          {"process.most_path_error_mm", "an interlock"},
          {"process.beside_mm", "an interlock"},
          {"ice.max_time_slip_s", "an interlock"},
          {"ice.max_pulses", "with the machine's valve.max_entries: the smaller counts"},
          {"valve_a.table_", "rows of a curve, which count together"},
          {"valve_b.table_", "rows of a curve, which count together"},
          {"calibration.", "where things stand on the table, as gauged"},
          {"plant.ice.drift_", "drawn together by seed and kept within the valve's range"},
          {"plant.ice.origin_dx_mm", "a displacement of any size"},
          {"plant.ice.origin_dy_mm", "a displacement of any size"},
          {"plant.ice.origin_dz_mm", "a displacement of any size"},
          {"plant.ice.laser_dx_mm", "a displacement of any size"},
          {"plant.ice.laser_dy_mm", "a displacement of any size"},
          {"plant.ice.laser_dz_mm", "a displacement of any size"},
          {"plant.ice.valve_a_dx_mm", "a displacement of any size"},
          {"plant.ice.valve_a_dy_mm", "a displacement of any size"},
          {"plant.ice.valve_b_dx_mm", "a displacement of any size"},
          {"plant.ice.valve_b_dy_mm", "a displacement of any size"},
          {"plant.profiler_d", "a displacement of any size"},
          {"plant.ice.jig_mm", "five numbers a block, which count together"},
      },
  });
}
