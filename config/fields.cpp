#include "config/fields.h"

#include <algorithm>
#include <stdexcept>

#include "config/device_kinds.h"
#include "config/field_rows.h"
#include "config/labs.h"
#include "core/control/controller.h"
#include "core/control/surface/surface_controller.h"
#include "core/deposition/offset_change.h"

namespace firn {
using namespace field_rows;

namespace {

constexpr double kLong = control::kMaxSeed;

Limits shapes() {
  std::vector<std::string_view> all(shape_kinds().begin(), shape_kinds().end());
  all.push_back("height_map");
  all.push_back("mesh");
  return one_of(all);
}

Limits solids() { return one_of({solid_kinds().begin(), solid_kinds().end()}); }

Limits or_python(Limits limits) {
  limits.or_python = true;
  return limits;
}

Limits schemes() {
  std::vector<std::string_view> names;
  for (const control::Scheme& s : control::schemes()) names.push_back(s.name);
  for (const control::SurfaceScheme& s : control::surface_schemes())
    if (std::find(names.begin(), names.end(), s.name) == names.end()) names.push_back(s.name);
  return or_python(one_of(names));
}

Table part_fields(Experiment& e) {
  ShapeSpec& s = e.part.shape;
  Table t = rows("grid.", e.grid, kGridSpec);
  add(t,
      {
          {"part.shape", &s.kind, "", shapes(),
           "outline and height; height_map takes them from part.image, mesh from part.mesh"},
          {"part.image", &e.part.image, "", path(), "grey PNG, path relative to this file; black = no part"},
          {"part.image_white_mm", &e.part.image_white_mm, "mm", above(0, 1000),
           "height of the brightest grey value"},
          {"part.um_per_px", &e.part.um_per_px, "um", within(0, 1e5),
           "height_map, geometry.images: side of a pixel; 0 = a picture is as wide as the part"},
          {"part.mesh", &e.part.mesh, "", path(),
           "mesh: file (STL, PLY, OBJ, 3MF) printed with one ink; path relative to this file"},
          {"part.mesh_scale_xy", &e.part.mesh_scale_xy, "", above(0, 1e6), "mesh: factor along x and y"},
          {"part.mesh_scale_z", &e.part.mesh_scale_z, "", above(0, 1e6), "mesh: factor along z"},
      });
  add(t, rows("part.", s, kShapeSpec));
  return t;
}

Table geometry_fields(Experiment& e) {
  SolidSpec& s = e.geometry.solid;
  Table t{
      {"geometry.shape", &s.kind, "", solids(),
       "two inks: the object inside the block of [part], all else is support [Lu 2015, IV-B]; none = one "
       "ink"},
  };
  add(t, rows("geometry.", s, kSolidSpec));
  add(t,
      {
          {"geometry.images", &e.geometry.images, "", path(),
           "images: folder of grey PNGs of one size in the middle of the grid, one layer each in the order "
           "of their names, bottom first; white = object"},
          {"geometry.image_pitch_z_mm", &e.geometry.image_pitch_z_mm, "mm", kImagePitch_mm,
           "images: height of one layer"},
          {"geometry.mesh", &e.geometry.mesh, "", path(),
           "mesh: file (STL, PLY, OBJ, 3MF) whose inside is the object; stands in the middle of the grid"},
          {"geometry.mesh_scale_xy", &e.geometry.mesh_scale_xy, "", above(0, 1e6),
           "mesh: factor along x and y"},
          {"geometry.mesh_scale_z", &e.geometry.mesh_scale_z, "", above(0, 1e6), "mesh: factor along z"},
          {"geometry.mesh_z_mm", &e.geometry.mesh_z_mm, "mm", within(-1000, 1000),
           "mesh: height of its lowest point"},
          {"geometry.judge_above_layers", &e.geometry.judge_above_layers, "layers", within(0, 1),
           "a cell's ink is that of M this far above its surface: 0 = at it [Lu 2015, IV-B], 0.5 = in the "
           "middle "
           "of the droplet to come"},
      });
  return t;
}

Table model_fields(Experiment& e) {
  ModelConfig& m = e.model;
  using namespace deposition;
  return {
      row("model.h1_mm", m.h1_mm, kModelH1),
      row("model.h2_mm", m.h2_mm, kModelH2),
      row("model.h3_mm", m.h3_mm, kModelH3),
      row("model.g1_mm", m.g1_mm, kModelH1, "two inks: height under a droplet of support [Lu 2015, III-D]"),
      row("model.g2_mm", m.g2_mm, kModelH2, "two inks: beside a droplet of support, per edge"),
      row("model.g3_mm", m.g3_mm, kModelH3, "two inks: beside a droplet of support, per corner"),
      {"model.border", &m.border, "", one_of({"lose", "keep"}),
       "the grid's edge: droplets flow over it, or a wall holds them"},
  };
}

Table actuation_fields(Experiment& e) {
  Table t = rows("actuation.", e.actuation, kOffsetOptions);
  add(t,
      {{"actuation.heights_mm", &e.actuation.heights_mm, "mm", within(0, 10),
        "height that a droplet adds to 5 x 5 cells around its own, row by row from the lowest y, for each "
        "place but "
        "the centre; firn identify finds them; empty = mixed from model.h1_mm..h3_mm"},
       {"actuation.flow_range_mm", &e.actuation.flow_range_mm, "mm", deposition::kFlowRange_mm,
        "ground this much above a droplet's cell takes none of it; 0 = the range of [Lu 2015, (5)], k + w of "
        "each pair of cells, which ink that lands across a step exceeds"}});
  return t;
}

Table control_fields(Experiment& e) {
  ControlConfig& c = e.control;
  using namespace control;
  Table t{
      {"control.scheme", &c.scheme, "", schemes(),
       "who decides the next layer; ice: open_loop, smf, smf_adaptive or smf_foresee"},
      row("control.max_layers", c.max_layers, kControlMaxLayers),
      {"control.smoothing", &c.smoothing, "", within(0, 1),
       "1 = robust DCT smoothing of the map [Garcia 2010], 0 = raw map"},
      {"control.adapt_model", &c.adapt_model, "", or_own(one_of({"off", "on"})),
       "on: MPC plans with the h1..h3 that droplet_estimator has learned so far; own:NAME: with those that a "
       "program of your own sends"},
      {"control.height_estimate", &c.height_estimate, "", one_of({"map", "kalman"}),
       "what the scheme sees: the map, or the map blended with what the executed droplets must have added"},
      row("control.droplet_scatter", c.filter.droplet_scatter, droplet::kDropletScatter),
      {"control.droplet_factors", &c.droplet_factors, "", one_of({"off", "on", "together"}),
       "kalman: on: MPC plans with h1..h3 times what droplets were found to add while printing, one factor "
       "inside the part and one on its rim; together: the same, the flow told by full layers, and the inside "
       "waits for the rim (with control.mpc.finish_layers = 3)"},
      row("control.noise_gate", c.noise_gate, kControlNoiseGate),
      row("control.stall_layers", c.stall_layers, kControlStallLayers),
      row("control.rim_inset", c.rim_inset, kControlRimInset),
      row("control.target_offset_mm", c.target_offset_mm, kControlTargetOffset),
  };
  add(t, rows("control.open_loop.", c.open_loop, kOpenLoopOptions));
  add(t, rows("control.smf.", c.smf, kSmfOptions));
  add(t, rows("control.smf.", c.surface, OptionTable{kSurfaceSpeedRange, kSurfaceVersion}));
  add(t, rows("control.foresee.", c.surface.foresee, kSurfaceForeseeOptions));
  add(t, rows("control.threshold.", c.threshold, kThresholdOptions));
  add(t, rows("control.mpc.", c.mpc, kMpcOptions));
  add(t, {{"control.mpc.seed", &c.seed, "", within(0, kLong), "of the search's random order"}});
  add(t, rows("control.pattern.", c.pattern, kPatternOptions));
  add(t, rows("control.registration.", c.registration, kRegistrationOptions));
  for (const Scheme& s : control::schemes()) add(t, extra_fields(s.extra, s.name, c.extra));
  for (const SurfaceScheme& s : control::surface_schemes()) add(t, extra_fields(s.extra, s.name, c.extra));
  return t;
}

Table estimator_fields(Experiment& e) {
  Table t{{"estimator.droplets", &e.estimator.droplets, "", or_python(one_of({"off", "on", "camera"})),
           "on, or a class in Python: droplet_estimator learns h1..h3 from drops and maps, layer by layer; "
           "camera: "
           "also from the droplets' volume in strobe sweeps, the first before layer 1 is planned"}};
  add(t, rows("estimator.", e.estimator, droplet::kEstimatorOptions));
  return t;
}

Table lab_fields(Experiment& e) {
  ProcessConfig& p = e.process;
  JetBConfig& o = e.jet_b;
  Table t{
      {"process.pass_speed_mm_s", &p.pass_speed_mm_s, "mm/s", above(0, 1e4),
       "stage speed while the jet fires"},
      {"process.scan_speed_mm_s", &p.scan_speed_mm_s, "mm/s", above(0, 1e4),
       "stage speed while the profiler measures"},
      {"process.park_x_mm", &p.park_x_mm, "mm", within(-1e4, 1e4), "cure and idle pose"},
      {"process.park_y_mm", &p.park_y_mm, "mm", within(-1e4, 1e4), "cure and idle pose"},
      {"process.nozzle_gap_mm", &p.nozzle_gap_mm, "mm", above(0, 100), "nozzle above the nominal surface"},
      {"process.nozzle_clearance_mm", &p.nozzle_clearance_mm, "mm", within(0, 100),
       "least height of the nozzle above the newest map, where a cell without a height counts as high; a map "
       "that reaches nearer is measured again, then stops the print (I6); 0 = not checked"},
      {"process.park_again", &p.park_again, "", one_of({"on", "off"}),
       "on: the stage parks again before an exposure that a stop cut off (I9)"},
      {"process.exposure_s", &p.exposure_s, "s", within(0, 3600), "UV exposure per layer"},
      {"process.iris_percent", &p.iris_percent, "%", within(1, 100), "opening of the lamp's iris"},
      {"process.sub_patterns", &p.sub_patterns, "", within(1, 4),
       "1, 2 or 4 interlaced patterns per layer, with a cure after each, so that wet droplets keep apart [Lu "
       "2015, V-D.2]"},
      {"process.max_rescans", &p.max_rescans, "", within(0, 100),
       "scans of one layer repeated when its map is rejected"},
      {"process.min_measured_fraction", &p.min_measured_fraction, "", within(0, 1),
       "of the part's cells, else the map is rejected"},
      {"process.max_lost_rows_share", &p.max_lost_rows_share, "", within(0, 1),
       "of a scan's rows: with more lost it is made again at half the speed; 1 = never"},
      {"process.least_rise_share", &p.least_rise_share, "", within(0, 1),
       "of what a layer's droplets deposit: one that rose by less was printed by a dead nozzle, which stops "
       "the "
       "print; 0 = never"},
      {"process.most_rise_share", &p.most_rise_share, "", within(1, 1e6),
       "of what a layer or an interval deposits: one that rose by more has a leak, which stops the print"},
      {"process.most_beside_share", &p.most_beside_share, "", within(0, 1e6),
       "lines: of the planned ink, away from them: more stops the print, the shutter stays open"},
      {"process.most_path_error_mm", &p.most_path_error_mm, "mm", above(0, 100),
       "lines: distance of the followed from the planned path, of the stage from its place on it, or of a "
       "switch of the shutter from its own: more stops the print"},
      {"process.beside_mm", &p.beside_mm, "mm", within(0, 100),
       "lines: away from them is farther than this from their nominal surface"},
  };
  add(t, rows("stage.", e.stage, drivers::kStageConfig));
  add(t, rows("jet.", e.jet, drivers::kJetConfig));
  add(t, {
             {"jet_b.offset_x_mm", &o.offset_x_mm, "mm", within(-1000, 1000),
              "nozzle of ink B relative to that of ink A, as the lab believes; firn calibrate measures it"},
             {"jet_b.offset_y_mm", &o.offset_y_mm, "mm", within(-1000, 1000), "the same along y"},
             {"jet_b.offset_z_mm", &o.offset_z_mm, "mm", within(-50, 50),
              "how much higher the stage's z is for the same gap"},
         });
  add(t, rows("jet_b.", o.drive, drivers::kJetConfig));
  add(t, rows("laser_profiler.", e.laser_profiler, drivers::kLaserProfilerConfig));
  add(t, rows("lamp.", e.lamp, drivers::kLampConfig));
  add(t, rows("camera.", e.camera, drivers::kCameraConfig));
  add(t, rows("watch.", e.watch, droplet::kWatchOptions));
  return t;
}

Limits natures() {
  std::vector<std::string_view> names;
  for (const plant::NatureName& n : plant::kNatureNames) names.push_back(n.name);
  return or_python(one_of(names));
}

/// Keys that one word of plant.model alone has.
Table nature_fields(plant::NatureOptions& options) {
  Table t;
  plant::for_each_nature(options, [&](std::string_view name, auto& own, const auto& table) {
    Table keys = rows("plant." + std::string(name) + ".", own, table);
    for (Field& f : keys) f.nature = name;
    add(t, keys);
  });
  return t;
}

Table plant_fields(Experiment& e) {
  PlantConfig& p = e.plant;
  Table t{
      {"plant.model", &p.model, "", natures(),
       "physics of the simulated lab: Firn's own, the paper's, others' structures (docs/worlds.md), or a "
       "class in Python"},
      {"plant.seed", &p.seed, "", within(0, kLong), "of all disturbances"},
      {"plant.ratio_b", &p.ratio_b, "", within(0.01, 100),
       "two inks: volume of a droplet of support by one of the object"},
      {"plant.variation", &p.variation, "", within(0, 1),
       "lu2015: upward variation of h1..h3, per droplet and layer"},
      {"plant.droplet", &p.droplet, "", one_of({"fitted", "droplet413"}),
       "droplets: shape on the ground, fitted to Table I's heights, or 413 um across as measured [Lu 2015, "
       "Fig. 18]"},
      {"plant.slope_bias_mm", &p.slope_bias_mm, "mm", within(1e-4, 1e6),
       "droplets: ground this much below the mean under a droplet gets twice its share; large = off [U]"},
      {"plant.flow", &p.flow, "", within(0.5, 2),
       "droplets: volume in shares of that which Table I's heights give"},
      {"plant.spread", &p.spread, "", within(0.75, 1.5),
       "droplets: radii of cap and film in shares of those which Table I's heights give"},
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
      {"plant.profiler_dx_mm", &p.profiler_dx_mm, "mm", within(-100, 100),
       "where the profiler truly measures, beyond the place that the lab believes"},
      {"plant.profiler_dy_mm", &p.profiler_dy_mm, "mm", within(-100, 100), "the same along y"},
      {"plant.profiler_dz_mm", &p.profiler_dz_mm, "mm", within(-100, 100), "by which it reads too high"},
      {"plant.camera.drop_speed_m_s", &p.camera.drop_speed_m_s, "m/s", within(0, 20),
       "of droplets as they leave the nozzle: they fly on with the stage; 0 = they land at once, and the "
       "camera sees 2 m/s"},
      {"plant.camera.drop_angle_deg", &p.camera.drop_angle_deg, "deg", within(-30, 30),
       "of the jet in the camera's pictures"},
      {"plant.camera.drop_jitter_us", &p.camera.drop_jitter_us, "us", within(0, 100),
       "standard deviation of the firing time"},
      {"plant.camera.break_off_us", &p.camera.break_off_us, "us", within(1, 1e4),
       "until the droplet leaves its ligament"},
      {"plant.camera.satellites", &p.camera.satellites, "", within(0, 4), "of each droplet"},
      {"plant.camera.um_per_px", &p.camera.um_per_px, "um", within(0.1, 100), "true scale of the pictures"},
      {"plant.camera.nozzle_um", &p.camera.nozzle_um, "um", within(0, 1e4),
       "true width of the nozzle; 0 = outside the picture"},
      {"plant.camera.width_px", &p.camera.width_px, "", within(64, 4096), "of a picture"},
      {"plant.camera.height_px", &p.camera.height_px, "", within(64, 4096), "of a picture"},
      {"plant.camera.blur_px", &p.camera.blur_px, "", within(0, 10), "standard deviation of the optics"},
      {"plant.camera.noise", &p.camera.noise, "", within(0, 0.2), "of a pixel, share of white"},
      {"plant.camera.light", &p.camera.light, "", within(0.1, 1.5), "of the ground, share of white"},
      {"plant.camera.uneven", &p.camera.uneven, "", within(0, 1), "of the light, corner to middle"},
      {"plant.camera.dirt", &p.camera.dirt, "", within(0, 100), "specks on the window"},
      {"plant.camera.dead_before", &p.camera.dead_before, "", within(0, 1000),
       "purges until the nozzle jets; 0 = it does"},
      {"plant.camera.best_dwell_us", &p.camera.best_dwell_us, "us", within(0, 1000),
       "time between the middles of the waveform's first two slopes at which droplets are fastest: they have "
       "drop_speed_m_s there at 20 V; 0 = the waveform does not act on them"},
      {"plant.camera.threshold_v", &p.camera.threshold_v, "V", within(0, 19),
       "of the first pulse: nothing leaves the nozzle below it"},
  };
  add(t, nature_fields(p.nature));
  add(t, rows("plant.sensor.", p.faults.sensor, plant::kSensorOptions));
  add(t, rows("plant.nozzle.", p.faults.nozzle, plant::kNozzleFaults));
  add(t, rows("plant.stage.", p.faults.stage, plant::kStageFaults));
  return t;
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

Field only_if_given(Field f) {
  f.only_if_given = true;
  return f;
}

Limits kinds_of(std::string_view node) {
  for (const DeviceKinds& kinds : kDeviceKinds) {
    if (kinds.node != node) continue;
    Limits limits = one_of({});
    for (const std::string_view word : kinds.words)
      if (!word.empty()) limits.choices.push_back(word);
    limits.or_python = kinds.or_python;
    return limits;
  }
  return one_of({});  // one kind alone
}

Table device_fields(Experiment& e) {
  Table t;
  for (const DevicePort& port : kDevicePorts) {
    const std::string node(port.node);
    t.push_back(
        {"devices." + node + ".port", &(e.devices.*port.member), "", text(),
         port.node == kDevicePorts[0].node
             ? "where the instrument is: sim:, tcp:HOST:PORT, serial:FILE?baud=N&frame=8N1, unix:PATH, "
               "cassette:FILE"
             : "the same"});
    t.push_back(only_if_given(
        {"devices." + node + ".host", &e.hosts.of_node[node], "", text(),
         port.node == kDevicePorts[0].node
             ? "name in [hosts] of the computer that the instrument is at; empty: the launcher's"
             : "the same"}));
    if (const Limits kinds = kinds_of(node); !kinds.choices.empty())
      t.push_back(
          only_if_given({"devices." + node + ".kind", &e.devices.kind[node], "", kinds,
                         node == kDevicePorts[0].node
                             ? "who speaks with the instrument: a kind of its class, or a driver class "
                               "in Python (docs/write-a-driver.md); empty: the first kind"
                             : "the same"}));
  }
  add(t, rows("devices.stage.dialect.", e.stage.dialect, drivers::kStageDialect));
  add(t, rows("devices.jet.dialect.", e.jet.dialect, drivers::kJetDialect));
  add(t, rows("devices.jet_b.dialect.", e.jet_b.drive.dialect, drivers::kJetDialect));
  add(t, rows("devices.lamp.dialect.", e.lamp.dialect, drivers::kLampDialect));
  add(t, rows("devices.robot.dialect.", e.robot.dialect, drivers::kRobotDialect));
  add(t, rows("devices.valve_a.dialect.", e.valve_a.dialect, drivers::kValveDialect));
  add(t, rows("devices.valve_b.dialect.", e.valve_b.dialect, drivers::kValveDialect));
  add(t, rows("devices.laser_point.dialect.", e.laser_point.dialect, drivers::kLaserPointDialect));
  return t;
}

Table host_fields(Experiment& e) {
  Table t;
  for (const std::string_view node : kMovableNodes)
    t.push_back(only_if_given(
        {"nodes." + std::string(node) + ".host", &e.hosts.of_node[std::string(node)], "", text(),
         "name in [hosts] of the computer that runs this process; empty: the launcher's"}));
  for (auto& [name, address] : e.hosts.address)
    t.push_back(only_if_given({"hosts." + name, &address, "", text(),
                               "name of this computer for ssh, perhaps with the place of firn: "
                               "USER@HOST[:/path/to/firn]"}));
  return t;
}

Table own_program_fields(Experiment& e) {
  Table t;
  for (auto& [name, program] : e.own_programs) {
    const std::string section = "nodes." + name + ".";
    t.push_back(only_if_given({section + "command", &program.command, "", text(),
                               "program of the lab's own that the print starts, as /bin/sh takes it"}));
    t.push_back(only_if_given({section + "needed", &program.needed, "", one_of({"on", "off"}),
                               "on: the print stops safely when the program ends; off: it goes on"}));
    t.push_back(
        only_if_given({section + "longest_silence_s", &program.longest_silence_s, "s", within(0, 3600),
                       "wall time without a message of the program, after which it counts as ended; 0 = "
                       "it may be silent"}));
  }
  return t;
}

}  // namespace

std::vector<Field> extra_fields(std::span<const control::ExtraOption> options, std::string_view scheme,
                                control::ExtraValues& values) {
  values.complete(options);
  Table t;
  for (const control::ExtraOption& o : options) {
    Field f{"control.extra." + std::string(o.name), {},    o.unit, o.range, o.meaning,
            o.change == Change::kBetweenLayers,     scheme};
    if (std::holds_alternative<double>(o.initial))
      f.value = &values.numbers.find(o.name)->second;
    else if (std::holds_alternative<std::int64_t>(o.initial))
      f.value = &values.integers.find(o.name)->second;
    else
      f.value = &values.texts.find(o.name)->second;
    f.limits.choices.assign(o.words.begin(), o.words.end());
    t.push_back(std::move(f));
  }
  return t;
}

bool belongs(const Field& field, const Experiment& e) {
  return belongs(field, e.lab.kind) && (field.scheme.empty() || field.scheme == e.control.scheme) &&
         (field.nature.empty() || field.nature == e.plant.model);
}

std::vector<Field> fields(Experiment& e) {
  Table t = {
      {"run.name", &e.run.name, "", text(),
       "last part of the run folder's name: letters, digits, '.', '_', '-'"},
      {"run.time_scale", &e.run.time_scale, "", within(1, 10),
       "live: node time runs this many times faster than wall time"},
      {"run.lease_s", &e.run.lease_s, "s", above(0, 10),
       "a driver without a lease for this long (wall time) makes its instrument safe"},
      {"run.safety_period_s", &e.run.safety_period_s, "s", above(0, 5), "wall time between leases"},
      {"run.clock_slack_ms", &e.run.clock_slack_ms, "ms", above(0, 1000),
       "most by which the clock of another host may be unknown"},
  };
  add(t, part_fields(e));
  add(t, geometry_fields(e));
  add(t, model_fields(e));
  add(t, actuation_fields(e));
  add(t, control_fields(e));
  add(t, estimator_fields(e));
  add(t, lab_fields(e));
  add(t, ice_fields(e));
  add(t, plant_fields(e));
  add(t, ice_plant_fields(e));
  add(t, bus_fields(e));
  add(t, device_fields(e));
  for (const LabKind* lab : lab_kinds())
    if (lab->fields) add(t, lab->fields(e));
  add(t, host_fields(e));
  add(t, own_program_fields(e));
  return t;
}

}  // namespace firn
