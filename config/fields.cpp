#include "config/fields.h"

#include <algorithm>

#include "config/field_rows.h"
#include "core/control/controller.h"
#include "core/control/surface/surface_controller.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kLong = 9e18;  // below 2^63: what a TOML integer can hold
constexpr double kMaxLayers = 1e6;

Limits shapes() {
  std::vector<std::string_view> all(shape_kinds().begin(), shape_kinds().end());
  all.push_back("height_map");
  return one_of(all);
}

Limits solids() { return one_of({solid_kinds().begin(), solid_kinds().end()}); }

Limits schemes() {
  std::vector<std::string_view> names;
  for (const control::Scheme& s : control::schemes()) names.push_back(s.name);
  for (const control::SurfaceScheme& s : control::surface_schemes())
    if (std::find(names.begin(), names.end(), s.name) == names.end()) names.push_back(s.name);
  return one_of(names);
}

Table part_fields(Experiment& e) {
  ShapeSpec& s = e.part.shape;
  return {
      {"grid.nx", &e.grid.nx, "", within(1, kMaxGridSide), "cells along x"},
      {"grid.ny", &e.grid.ny, "", within(1, kMaxGridSide), "cells along y"},
      {"grid.pitch_x_mm", &e.grid.pitch_x_mm, "mm", above(0, 100),
       "distance of cells along x [Lu 2015, Table I]"},
      {"grid.pitch_y_mm", &e.grid.pitch_y_mm, "mm", above(0, 100), "distance of cells along y"},
      {"grid.origin_x_mm", &e.grid.origin_x_mm, "mm", within(-1e4, 1e4),
       "stage position of the centre of cell (0, 0)"},
      {"grid.origin_y_mm", &e.grid.origin_y_mm, "mm", within(-1e4, 1e4), "the same along y"},
      {"part.shape", &s.kind, "", shapes(), "outline and height; height_map takes them from part.image"},
      {"part.image", &e.part.image, "", text(),
       "grey PNG, path relative to the experiment file; black = no part"},
      {"part.image_white_mm", &e.part.image_white_mm, "mm", above(0, 1000),
       "height of the brightest grey value"},
      {"part.height_mm", &s.height_mm, "mm", above(0, 1000), "height of the part (wedge: of its high end)"},
      {"part.diameter_mm", &s.diameter_mm, "mm", within(0, 1e4),
       "cylinder, pipe, cone, dome: (outer) diameter"},
      {"part.inner_diameter_mm", &s.inner_diameter_mm, "mm", within(0, 1e4), "pipe: inner diameter"},
      {"part.width_mm", &s.width_mm, "mm", within(0, 1e4), "cuboid, wedge: size along x"},
      {"part.depth_mm", &s.depth_mm, "mm", within(0, 1e4), "cuboid, wedge: size along y"},
      {"part.low_height_mm", &s.low_height_mm, "mm", within(0, 1000),
       "wedge: height of its low end; cone: of its rim"},
  };
}

Table geometry_fields(Experiment& e) {
  SolidSpec& s = e.geometry.solid;
  return {
      {"geometry.shape", &s.kind, "", solids(),
       "two inks: the object inside the block of [part], all else is support [Lu 2015, IV-B]; none = one "
       "ink"},
      {"geometry.outer_diameter_mm", &s.outer_diameter_mm, "mm", within(0, 1e4),
       "pipe, pipe_junction: standing pipe; ellipsoid: along x and y"},
      {"geometry.inner_diameter_mm", &s.inner_diameter_mm, "mm", within(0, 1e4),
       "pipe, pipe_junction: bore of the standing pipe"},
      {"geometry.branch_width_mm", &s.branch_width_mm, "mm", within(0, 1e4),
       "pipe_junction: lying pipe, along y"},
      {"geometry.branch_height_mm", &s.branch_height_mm, "mm", within(0, 1000),
       "pipe_junction: lying pipe, along z"},
      {"geometry.branch_bore_width_mm", &s.branch_bore_width_mm, "mm", within(0, 1e4),
       "pipe_junction: bore of the lying pipe, along y"},
      {"geometry.branch_bore_height_mm", &s.branch_bore_height_mm, "mm", within(0, 1000),
       "pipe_junction: bore of the lying pipe, along z"},
      {"geometry.centre_z_mm", &s.centre_z_mm, "mm", within(0, 1000),
       "pipe_junction: axis of the lying pipe; ellipsoid: centre"},
      {"geometry.height_mm", &s.height_mm, "mm", within(0, 1000), "ellipsoid: along z"},
      {"geometry.images", &e.geometry.images, "", text(),
       "images: folder of grey PNGs, one layer each in the order of their names, bottom first; white = "
       "object"},
      {"geometry.image_pitch_z_mm", &e.geometry.image_pitch_z_mm, "mm", above(0, 100),
       "images: height of one layer"},
      {"geometry.mesh", &e.geometry.mesh, "", text(),
       "mesh: file (STL, PLY, OBJ, 3MF) whose inside is the object; stands in the middle of the grid"},
      {"geometry.mesh_scale_xy", &e.geometry.mesh_scale_xy, "", above(0, 1e6), "mesh: factor along x and y"},
      {"geometry.mesh_scale_z", &e.geometry.mesh_scale_z, "", above(0, 1e6), "mesh: factor along z"},
      {"geometry.mesh_z_mm", &e.geometry.mesh_z_mm, "mm", within(-1000, 1000),
       "mesh: height of its lowest point"},
      {"geometry.judge_above_layers", &e.geometry.judge_above_layers, "layers", within(0, 1),
       "a cell's ink is that of M this far above its surface: 0 = at it [Lu 2015, IV-B], 0.5 = in the middle "
       "of the droplet to come"},
  };
}

Table control_fields(Experiment& e) {
  SmfConfig& s = e.control.smf;
  ForeseeConfig& f = e.control.foresee;
  MpcConfig& m = e.control.mpc;
  PatternConfig& p = e.control.pattern;
  return {
      {"model.h1_mm", &e.model.h1_mm, "mm", above(0, 10), "height under a droplet [Lu 2015, Table I]"},
      {"model.h2_mm", &e.model.h2_mm, "mm", within(0, 10), "height beside a droplet, per edge"},
      {"model.h3_mm", &e.model.h3_mm, "mm", within(0, 10), "height beside a droplet, per corner"},
      {"model.g1_mm", &e.model.g1_mm, "mm", above(0, 10),
       "two inks: height under a droplet of support [Lu 2015, III-D]"},
      {"model.g2_mm", &e.model.g2_mm, "mm", within(0, 10), "two inks: beside a droplet of support, per edge"},
      {"model.g3_mm", &e.model.g3_mm, "mm", within(0, 10),
       "two inks: beside a droplet of support, per corner"},
      {"model.border", &e.model.border, "", one_of({"lose", "keep"}),
       "the grid's edge: droplets flow over it, or a wall holds them"},
      {"control.scheme", &e.control.scheme, "", schemes(),
       "who decides the next layer; ice: open_loop, smf, smf_adaptive or smf_foresee"},
      {"control.max_layers", &e.control.max_layers, "", within(1, kMaxLayers),
       "the print stops for the operator beyond this"},
      {"control.smoothing", &e.control.smoothing, "", within(0, 1),
       "1 = robust DCT smoothing of the map [Garcia 2010], 0 = raw map"},
      {"control.adapt_model", &e.control.adapt_model, "", one_of({"off", "on"}),
       "on: MPC plans with the h1..h3 that droplet_estimator has learned so far"},
      {"control.height_estimate", &e.control.height_estimate, "", one_of({"map", "kalman"}),
       "what the scheme sees: the map, or the map blended with what the executed droplets must have added"},
      {"control.droplet_scatter", &e.control.droplet_scatter, "", within(0, 1),
       "kalman: relative standard deviation of a droplet; with adapt_model what droplet_estimator has "
       "learned takes its place"},
      {"control.droplet_factors", &e.control.droplet_factors, "", one_of({"off", "on", "together"}),
       "kalman: on: MPC plans with h1..h3 times what droplets were found to add while printing, one factor "
       "inside the part and one on its rim; together: the same, the flow told by full layers, and the inside "
       "waits for the rim (with control.mpc.finish_layers = 3)"},
      {"control.noise_gate", &e.control.noise_gate, "", within(0, 100),
       "SMF and MPC end when a layer would better the part by no more than this many sensor sigmas per "
       "droplet"},
      {"control.open_loop.layers", &e.control.open_loop.layers, "", within(0, kMaxLayers),
       "full layers; 0 = per cell, target height by nominal layer height"},
      {"control.smf.kp", &s.kp, "", within(0, 10), "proportional gain [Barnett, (5.1)]"},
      {"control.smf.ki_star", &s.ki_star, "", within(0, 10), "integral gain, adjusted by (5.2)"},
      {"control.smf.kd_star", &s.kd_star, "", within(0, 10), "derivative gain, adjusted by (5.2)"},
      {"control.smf.output_limit", &s.output_limit, "layers", above(0, 255),
       "bound of the output u', either sign"},
      {"control.smf.integral_limit", &s.integral_limit, "layers", within(0, 1000),
       "bound of the integral part (anti-windup)"},
      {"control.smf.layer_height_mm", &s.layer_height_mm, "mm", within(0, 10),
       "nominal layer; 0 = h1 + 4 h2 + 4 h3"},
      {"control.smf.max_drops", &s.max_drops, "", within(1, 255), "droplets per cell and layer"},
      {"control.smf.rounding", &s.rounding, "", one_of({"nearest", "diffusion", "carry"}),
       "what becomes of fractions of a droplet: dropped, spread to neighbours, kept for the next layer"},
      {"control.smf.speed_range", &s.speed_range, "", within(0, 0.9),
       "ice: the c-controller keeps the path speed within this share of nominal [5.2.2]"},
      {"control.smf.version", &s.version, "", one_of({"speed", "frequency"}),
       "ice: what carries the action: the path speed (c-controller) [Barnett, (5.8)] or the valve frequency "
       "(nu-controller) [(6.3)]"},
      {"control.foresee.kp", &f.kp, "", above(0, 10), "ice, scheme smf_foresee: proportional gain"},
      {"control.foresee.flow_gain", &f.flow_gain, "", within(0, 1),
       "share of a material's unforeseen mean error that is taken for lasting"},
      {"control.foresee.zone_gain", &f.zone_gain, "", within(0, 1),
       "the same of a zone's mean, beyond its material's; a zone is a band of distances to the border of a "
       "material"},
      {"control.foresee.zone_mm", &f.zone_mm, "mm", above(0.1, 1000), "width of that band"},
      {"control.foresee.wide_gain", &f.wide_gain, "", within(0, 1),
       "share of an unforeseen error wider than wide_mm, beyond its zone's mean, that is taken for lasting"},
      {"control.foresee.wide_mm", &f.wide_mm, "mm", above(0.1, 1000),
       "side of the squares it is averaged over"},
      {"control.foresee.narrow_gain", &f.narrow_gain, "", within(0, 2),
       "share of an error narrower than narrow_mm that is answered"},
      {"control.foresee.narrow_mm", &f.narrow_mm, "mm", above(0.1, 1000),
       "side of the squares that tell narrow from wide"},
      {"control.threshold.threshold_mm", &e.control.threshold.threshold_mm, "mm", within(0, 10),
       "a cell that is short by more gets a droplet; 0 = half a layer"},
      {"control.threshold.layer_height_mm", &e.control.threshold.layer_height_mm, "mm", within(0, 10),
       "nominal layer; 0 = h1 + 4 h2 + 4 h3"},
      {"control.mpc.method", &m.method, "", one_of({"greedy", "descent", "strip_dp", "certified"}),
       "greedy: the paper's stochastic search [Lu 2015, IV-C]; descent: the same single droplets in raster "
       "order; strip_dp: exact optima of overlapping strips, for horizon > 1 strips of each layer and "
       "annealing: the best; certified: one layer within a tenth of a percent of the optimum, several as "
       "strip_dp"},
      {"control.mpc.strip_rows", &m.strip_rows, "rows", within(1, 6),
       "strip_dp: widest strip; one row more costs about six times the time"},
      {"control.mpc.anneal_sweeps", &m.anneal_sweeps, "", within(0, 1e6),
       "strip_dp with horizon > 1: sweeps of annealing over all cells and layers; 0 = none"},
      {"control.mpc.horizon", &m.horizon, "layers", within(1, 20), "N of [Lu 2015, (8)]"},
      {"control.mpc.error", &m.error, "", one_of({"absolute", "square", "square_mean"}),
       "what an error costs: absolute: its mean, as in (8); square: its root mean square, with the variance "
       "that droplets add (control.droplet_scatter); square_mean: the same and eight times the square of the "
       "part's mean error"},
      {"control.mpc.alpha", &m.alpha, "", within(0, 1),
       "weight of the mean error against the roughness in (8); a number, or [{from_layer = 1, alpha = 1.0}, "
       "...]"},
      {"control.mpc.subset", &m.subset, "cells", within(1, 4096),
       "M: points tried together in the greedy search [Lu 2015, IV-C]"},
      {"control.mpc.max_evaluations", &m.max_evaluations, "", within(1, 1e12),
       "bound of the work per decision"},
      {"control.mpc.max_drops", &m.max_drops, "", within(1, 255), "droplets per cell and layer"},
      {"control.mpc.finish_layers", &m.finish_layers, "layers", within(0, 20),
       "the part is first printed to so many layers below its target, its rim too, and only then finished; 0 "
       "= in one stage"},
      {"control.mpc.min_improvement_mm", &m.min_improvement_mm, "mm", within(0, 10),
       "the print ends when the best layer betters printing nothing by no more"},
      {"control.mpc.seed", &m.seed, "", within(0, kLong), "of the search's random order"},
      {"control.pattern.kind", &p.kind, "", one_of({"random", "identification", "squares"}),
       "what scheme pattern prints [Lu 2015, III-A, V-C]"},
      {"control.pattern.layers", &p.layers, "", within(0, kMaxLayers),
       "patterns; 0 = as many full layers as the highest cell needs"},
      {"control.pattern.fill", &p.fill, "", above(0, 1), "random: probability of a droplet"},
      {"control.pattern.spacing_cells", &p.spacing_cells, "cells", within(1, 4096),
       "identification: between centres; squares: bare ground between"},
      {"control.pattern.largest_square", &p.largest_square, "droplets", within(1, 64),
       "squares: 1 x 1 up to this many a side"},
      {"control.pattern.square_step", &p.square_step, "cells", within(1, 4096),
       "squares: from droplet to droplet"},
      {"control.pattern.seed", &p.seed, "", within(0, kLong), "random: of the patterns"},
      {"control.registration.layers", &e.control.registration.layers, "", within(1, 1000),
       "droplets on each mark of a registration print"},
      {"control.registration.spacing_cells", &e.control.registration.spacing_cells, "cells", within(4, 4096),
       "between marks; those of the two nozzles alternate"},
      {"estimator.droplets", &e.estimator.droplets, "", one_of({"off", "on"}),
       "on: droplet_estimator learns h1..h3 from drops and maps, layer by layer"},
      {"estimator.window_layers", &e.estimator.window_layers, "layers", within(1, 1000),
       "layers that are estimated anew each time; older ones as a summary"},
      {"estimator.prior_std", &e.estimator.prior_std, "", above(0, 10),
       "relative standard deviation of what model.h1_mm..h3_mm are believed to be"},
      {"estimator.max_evaluations", &e.estimator.max_evaluations, "", within(10, 10000),
       "of the estimator's objective, per layer and round"},
      {"estimator.memory_layers", &e.estimator.memory_layers, "layers", within(0, 1e6),
       "forgetting: a layer so many layers old counts 1 - 1/M to that power, about 1/e; 0 = nothing is "
       "forgotten"},
  };
}

Table lab_fields(Experiment& e) {
  ProcessConfig& p = e.process;
  StageConfig& s = e.stage;
  JetConfig& j = e.jet;
  JetBConfig& o = e.jet_b;
  JetConfig& b = o.drive;
  LaserProfilerConfig& l = e.laser_profiler;
  return {
      {"process.pass_speed_mm_s", &p.pass_speed_mm_s, "mm/s", above(0, 1e4),
       "stage speed while the jet fires"},
      {"process.scan_speed_mm_s", &p.scan_speed_mm_s, "mm/s", above(0, 1e4),
       "stage speed while the profiler measures"},
      {"process.park_x_mm", &p.park_x_mm, "mm", within(-1e4, 1e4), "cure and idle pose"},
      {"process.park_y_mm", &p.park_y_mm, "mm", within(-1e4, 1e4), "cure and idle pose"},
      {"process.nozzle_gap_mm", &p.nozzle_gap_mm, "mm", above(0, 100), "nozzle above the nominal surface"},
      {"process.exposure_s", &p.exposure_s, "s", within(0, 3600), "UV exposure per layer"},
      {"process.iris_percent", &p.iris_percent, "%", within(1, 100), "opening of the lamp's iris"},
      {"process.sub_patterns", &p.sub_patterns, "", within(1, 4),
       "1, 2 or 4 interlaced patterns per layer, with a cure after each, so that wet droplets keep apart [Lu "
       "2015, V-D.2]"},
      {"process.max_rescans", &p.max_rescans, "", within(0, 100),
       "scans of one layer repeated when its map is rejected"},
      {"process.min_measured_fraction", &p.min_measured_fraction, "", within(0, 1),
       "of the part's cells, else the map is rejected"},
      {"stage.counts_per_mm", &s.counts_per_mm, "1/mm", above(0, 1e7), "encoder counts"},
      {"stage.acceleration_mm_s2", &s.acceleration_mm_s2, "mm/s^2", above(0, 1e6), "ramp rate"},
      {"stage.max_speed_mm_s", &s.max_speed_mm_s, "mm/s", above(0, 1e4), "of x and y"},
      {"stage.x_min_mm", &s.x_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.x_max_mm", &s.x_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.y_min_mm", &s.y_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.y_max_mm", &s.y_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.z_min_mm", &s.z_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.z_max_mm", &s.z_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
      {"stage.array_limit", &s.array_limit, "", within(1, 1'000'000),
       "firing distances that the controller holds"},
      {"stage.poll_moving_s", &s.poll_moving_s, "s", above(0, 10), "between status questions during a move"},
      {"stage.poll_idle_s", &s.poll_idle_s, "s", above(0, 60), "between status questions at rest"},
      {"jet.dwell_us", &j.dwell_us, "us", above(0, 3276), "waveform: time at dwell_v"},
      {"jet.echo_us", &j.echo_us, "us", within(0, 3276), "waveform: time at echo_v"},
      {"jet.rise_us", &j.rise_us, "us", within(1, 3276), "waveform: idle to dwell"},
      {"jet.fall_us", &j.fall_us, "us", within(1, 3276), "waveform: dwell to echo"},
      {"jet.final_us", &j.final_us, "us", within(1, 3276), "waveform: echo to idle"},
      {"jet.idle_v", &j.idle_v, "V", within(-140, 140), "waveform: level at rest"},
      {"jet.dwell_v", &j.dwell_v, "V", within(-140, 140), "waveform: first pulse"},
      {"jet.echo_v", &j.echo_v, "V", within(-140, 140), "waveform: second pulse"},
      {"jet.max_rate_hz", &j.max_rate_hz, "Hz", within(1, 30'000), "droplet rate that stays stable"},
      {"jet_b.offset_x_mm", &o.offset_x_mm, "mm", within(-1000, 1000),
       "nozzle of ink B relative to that of ink A, as the lab believes; firn calibrate measures it"},
      {"jet_b.offset_y_mm", &o.offset_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"jet_b.offset_z_mm", &o.offset_z_mm, "mm", within(-50, 50),
       "how much higher the stage's z is for the same gap"},
      {"jet_b.dwell_us", &b.dwell_us, "us", above(0, 3276), "waveform: time at dwell_v"},
      {"jet_b.echo_us", &b.echo_us, "us", within(0, 3276), "waveform: time at echo_v"},
      {"jet_b.rise_us", &b.rise_us, "us", within(1, 3276), "waveform: idle to dwell"},
      {"jet_b.fall_us", &b.fall_us, "us", within(1, 3276), "waveform: dwell to echo"},
      {"jet_b.final_us", &b.final_us, "us", within(1, 3276), "waveform: echo to idle"},
      {"jet_b.idle_v", &b.idle_v, "V", within(-140, 140), "waveform: level at rest"},
      {"jet_b.dwell_v", &b.dwell_v, "V", within(-140, 140), "waveform: first pulse"},
      {"jet_b.echo_v", &b.echo_v, "V", within(-140, 140), "waveform: second pulse"},
      {"jet_b.max_rate_hz", &b.max_rate_hz, "Hz", within(1, 30'000), "droplet rate that stays stable"},
      {"laser_profiler.points", &l.points, "", within(2, 800), "points of one profile"},
      {"laser_profiler.dx_mm", &l.dx_mm, "mm", within(0, 10),
       "distance of points; 0 = so that the line covers the grid"},
      {"laser_profiler.offset_y_mm", &l.offset_y_mm, "mm", within(-1000, 1000),
       "laser line relative to the nozzle"},
      {"laser_profiler.poll_s", &l.poll_s, "s", above(0, 10), "between questions for a new profile"},
      {"lamp.max_on_s", &e.lamp.max_on_s, "s", above(0, 3600),
       "longest exposure before the interlock closes the shutter"},
  };
}

Table plant_fields(Experiment& e) {
  PlantConfig& p = e.plant;
  return {
      {"plant.model", &p.model, "", one_of({"droplets", "lu2015"}),
       "Firn's own physics, or the paper's simulation"},
      {"plant.seed", &p.seed, "", within(0, kLong), "of all disturbances"},
      {"plant.ratio_b", &p.ratio_b, "", within(0.01, 100),
       "two inks: volume of a droplet of support by one of the object"},
      {"plant.variation", &p.variation, "", within(0, 1),
       "lu2015: upward variation of h1..h3, per droplet and layer"},
      {"plant.size_std", &p.size_std, "", within(0, 0.5), "droplets: relative scatter of the volume"},
      {"plant.placement_std_mm", &p.placement_std_mm, "mm", within(0, 10),
       "droplets: scatter of the landing point"},
      {"plant.missed_fraction", &p.missed_fraction, "", within(0, 1), "droplets: triggers without a drop"},
      {"plant.satellite_fraction", &p.satellite_fraction, "", within(0, 1),
       "droplets: drops with a satellite"},
      {"plant.drift", &p.drift, "", within(0, 1), "droplets: slow relative drift of the flow over a print"},
      {"plant.nozzle_b_x_mm", &p.nozzle_b_x_mm, "mm", within(-1000, 1000),
       "where the nozzle of ink B truly stands, relative to that of ink A"},
      {"plant.nozzle_b_y_mm", &p.nozzle_b_y_mm, "mm", within(-1000, 1000), "the same along y"},
      {"plant.sensor_noise_mm", &p.sensor_noise_mm, "mm", within(0, 1),
       "standard deviation of one height [Lu 2015, V-B]"},
      {"plant.dropout_fraction", &p.dropout_fraction, "", within(0, 1), "profile points without a reading"},
  };
}

Table bus_fields(Experiment& e) {
  BusConfig& b = e.bus;
  return {
      {"bus.loss", &b.loss, "", within(0, 0.9), "fault injection: received datagrams dropped"},
      {"bus.duplicate", &b.duplicate, "", within(0, 0.9), "fault injection: datagrams delivered twice"},
      {"bus.reorder", &b.reorder, "", within(0, 0.9), "fault injection: datagrams that overtake"},
      {"bus.delay", &b.delay, "", within(0, 0.9), "fault injection: datagrams held back"},
      {"bus.delay_s", &b.delay_s, "s", within(0, 10), "fault injection: longest hold, wall time"},
      {"bus.seed", &b.seed, "", within(0, kLong), "of the injected faults"},
  };
}

}  // namespace

std::vector<Field> fields(Experiment& e) {
  Table t = {
      {"run.name", &e.run.name, "", text(),
       "last part of the run folder's name: letters, digits, '.', '_', '-'"},
      {"run.time_scale", &e.run.time_scale, "", within(1, 10),
       "live: node time runs this many times faster than wall time"},
      {"run.lease_s", &e.run.lease_s, "s", above(0, 10),
       "a driver without a lease for this long (wall time) makes its instrument safe"},
      {"run.safety_period_s", &e.run.safety_period_s, "s", above(0, 5), "wall time between leases"},
  };
  add(t, part_fields(e));
  add(t, geometry_fields(e));
  add(t, control_fields(e));
  add(t, lab_fields(e));
  add(t, ice_fields(e));
  add(t, plant_fields(e));
  add(t, ice_plant_fields(e));
  add(t, bus_fields(e));
  return t;
}

}  // namespace firn
