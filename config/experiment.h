// Experiment holds part, model, controller, lab and plant of one experiment as plain structs. Defaults are
// Lu's ink-jet lab. Options of algorithms are core's and estimators' own structs. config/fields.cpp names
// every field with its unit, range and meaning; options structs hold these in their own tables. Parser,
// resolved dump and docs/configuration.md come from that one table.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config/aerosol.h"
#include "config/ice.h"
#include "config/own_programs.h"
#include "core/control/options.h"
#include "core/control/surface/surface_controller.h"
#include "core/deposition/height_change.h"
#include "core/grid/grid.h"
#include "core/grid/offsets.h"
#include "core/grid/shapes.h"
#include "core/grid/solids.h"
#include "drivers/camera/camera_config.h"
#include "drivers/gas/gas_config.h"
#include "drivers/jet/jet_config.h"
#include "drivers/lamp/lamp_config.h"
#include "drivers/laser_profiler/laser_profiler_config.h"
#include "drivers/stage/stage_config.h"
#include "estimators/droplet/options.h"
#include "estimators/droplet/watch_options.h"
#include "files/port_address.h"
#include "plant/options/natures.h"

namespace firn {

struct PartConfig {
  ShapeSpec shape;              ///< shape.kind "height_map" takes the image instead
  std::string image;            ///< PNG, path relative to the experiment file
  double image_white_mm = 0.4;  ///< height of the brightest grey value
  double um_per_px = 0.0;       ///< of the image; 0: shape.width_mm is its width
  std::string mesh;             ///< of shape.kind "mesh": STL, PLY, OBJ or 3MF, in the middle of the grid
  double mesh_scale_xy = 1.0;
  double mesh_scale_z = 1.0;
};

struct GeometryConfig {  ///< the part inside a block of support; the block is PartConfig's
  SolidSpec solid;       ///< kind "none": one ink
  std::string images;    ///< folder of PNG layers, path relative to the experiment file
  double image_pitch_z_mm = 0.0076;
  std::string mesh;  ///< STL, PLY, OBJ or 3MF, path relative to the experiment file; middle of the grid
  double mesh_scale_xy = 1.0;  ///< a flat lab prints a flat picture of a body
  double mesh_scale_z = 1.0;
  double mesh_z_mm = 0.0;  ///< height of the lowest point of the mesh
  double judge_above_layers =
      0.0;  ///< height above a cell's surface at which its ink is judged, in layers h1 + 4 h2 + 4 h3
};

struct ModelConfig {  ///< height model of the controllers [Lu 2015, Table I]
  double h1_mm = deposition::DropletModel{}.h1_mm;
  double h2_mm = deposition::DropletModel{}.h2_mm;
  double h3_mm = deposition::DropletModel{}.h3_mm;
  double g1_mm = deposition::DropletModel{}.h1_mm;  ///< two inks: the support's
  double g2_mm = deposition::DropletModel{}.h2_mm;
  double g3_mm = deposition::DropletModel{}.h3_mm;
  std::string border = "lose";  ///< "lose" or "keep"
};

using control::AlphaStep;

/// Options of the feedback schemes, of the smoothing before them and of the estimators beside them.
struct ControlConfig : control::ControlOptions {
  control::SurfaceOptions
      surface;             ///< ice: its gains are smf's, its scheme and interval follow from the lab's
  std::uint64_t seed = 1;  ///< of the search's random order
  double smoothing = 0.0;  ///< 1 = robust DCT smoothing with automatic parameter, 0 = raw map
  std::string adapt_model = "off";  ///< "on": h1..h3 of HEIGHT_MODEL take the place of model.h1_mm..h3_mm;
                                    ///< "own:NAME": those of OWN_HEIGHT_MODEL by that program
  std::string height_estimate =
      "map";  ///< "kalman": the map blended with the height predicted from the executed droplets
  droplet::HeightFilterOptions filter;  ///< of "kalman"; droplet_scatter until droplet_estimator reports one
  std::string droplet_factors =
      "off";  ///< "on", "together": learned inside the part and on its rim; rising together
};

struct EstimatorConfig : droplet::EstimatorOptions {  ///< estimators that learn from printed layers
  std::string droplets = "off";  ///< "on": droplet_estimator takes part and publishes HEIGHT_MODEL
};

struct ActuationConfig : OffsetOptions {  ///< where droplets may land inside their cells
  /// Height that a droplet at each place but the centre adds to 5 x 5 cells, as firn identify finds it: place
  /// by place, row by row from the lowest y. Empty: from model.h1_mm..h3_mm
  /// (core/deposition/offset_change.h).
  std::vector<double> heights_mm;
  double flow_range_mm = 0.0;  ///< deposition::OffsetModel::range_mm
};

struct ProcessConfig {  ///< how a layer is printed
  double pass_speed_mm_s = 150.0;
  double scan_speed_mm_s = 15.0;
  double park_x_mm = -5.0;  ///< cure and idle pose
  double park_y_mm = -5.0;
  double nozzle_gap_mm = 1.0;
  double nozzle_clearance_mm = 0.2;  ///< interlock I6
  std::string park_again = "on";     ///< interlock I9; "off": as before this key
  double exposure_s = 0.5;
  int iris_percent = 80;
  int sub_patterns = 1;  ///< interlaced patterns of a layer, each cured before the next [Lu 2015, V-D.2]
  int max_rescans = 2;   ///< of one layer when the map is rejected
  double min_measured_fraction = 0.8;  ///< interlock I13
  double max_lost_rows_share = 0.01;   ///< of a scan, else it is made again; 1 = never
  double least_rise_share = 0.3;       ///< interlock I12: of the expected rise of a layer of droplets
  double most_rise_share = 4.0;        ///< interlock I12
  double most_beside_share = 0.1;      ///< interlock I12, lines: of the planned ink, away from them
  double most_path_error_mm = 0.05;    ///< interlock I17, lines: of the followed from the planned path
  double beside_mm = 0.3;              ///< away from a line: farther than this from its nominal surface
};

using drivers::CameraConfig;
using drivers::GasConfig;
using drivers::JetConfig;
using drivers::LampConfig;
using drivers::LaserProfilerConfig;
using drivers::StageConfig;

struct JetBConfig {  ///< the jet of ink B; takes part only when has_two_jets()
  double offset_x_mm =
      20.0;  ///< position of nozzle B relative to the first jet's, as the lab believes: nozzle B is
  double offset_y_mm =
      0.0;  ///< above the part point (x, y) when the stage is at (x - offset_x, y - offset_y)
  double offset_z_mm = 0.0;  ///< how much higher the stage's z must be for the same gap
  JetConfig drive;           ///< its own waveform
};

struct PlantCameraConfig {  ///< the jet as the simulated camera sees it
  double drop_speed_m_s = 0.0;
  double drop_angle_deg = 0.0;
  double drop_jitter_us = 0.0;
  double break_off_us = 50.0;
  int satellites = 0;
  double um_per_px = 2.5;
  double nozzle_um = 300.0;
  int width_px = 400, height_px = 320;
  double blur_px = 1.0;
  double noise = 0.006;
  double light = 0.7;
  double uneven = 0.2;
  int dirt = 4;
  int dead_before = 0;
  double best_dwell_us = 0.0;  ///< 0: the waveform does not act on the speed
  double threshold_v = 8.0;
};

struct PlantConfig {
  std::string model = "droplets";  ///< plant/options/natures.h, or a class in Python
  std::uint64_t seed = 1;
  double ratio_b = 1.0;            ///< two inks: volume of a support droplet by an object droplet
  double variation = 0.2;          ///< lu2015: upward variation of h1..h3, per droplet and layer
  std::string droplet = "fitted";  ///< droplets: its shape, fitted to Table I, or "droplet413" as measured
  double slope_bias_mm = 0.01;     ///< droplets: ground this much below the mean gets twice its share
  double flow = 1.0;               ///< droplets: volume in shares of the calibrated one
  double spread = 1.0;             ///< droplets: radii in shares of the calibrated ones
  double size_std = 0.03;          ///< droplets: relative volume scatter
  double placement_std_mm = 0.008;
  double missed_fraction = 0.002;
  double satellite_fraction = 0.01;
  double drift = 0.1;           ///< slow relative flow drift over a print
  double nozzle_b_x_mm = 20.0;  ///< true position of nozzle B relative to nozzle A
  double nozzle_b_y_mm = 0.0;
  double sensor_noise_mm = 0.001;  ///< Lu V-B: 1 um
  double dropout_fraction = 0.005;
  double profiler_dx_mm = 0.0, profiler_dy_mm = 0.0,
         profiler_dz_mm = 0.0;  ///< true place beyond the believed one
  plant::NatureOptions nature;  ///< of the physics that `model` names
  plant::FaultOptions faults;
  PlantCameraConfig camera;
  IcePlantConfig ice;
  AerosolPlantConfig aerosol;
};

struct BusConfig {
  double loss = 0.0;  ///< of received datagrams, for fault injection
  double duplicate = 0.0;
  double reorder = 0.0;
  double delay = 0.0;
  double delay_s = 0.02;  ///< wall time
  std::uint64_t seed = 0;
};

struct DevicesConfig {  ///< port of each instrument: files/port_address.h; and its kind
  std::string stage = "sim:", jet = "sim:", jet_b = "sim:", laser_profiler = "sim:", lamp = "sim:";
  std::string robot = "sim:", valve_a = "sim:", valve_b = "sim:", laser_point = "sim:", heater = "sim:",
              camera = "sim:", gas = "sim:";
  std::map<std::string, std::string>
      kind;  ///< by node (config/device_kinds.h); empty: the first of its class
};
struct DevicePort {
  std::string_view node;
  std::string DevicesConfig::*member;
  PortDefaults defaults;  ///< TCP port, baud, wait after opening [ms]
};
inline constexpr DevicePort kDevicePorts[] = {
    {"stage", &DevicesConfig::stage, {8000, 115200, 0}},
    {"jet", &DevicesConfig::jet, {0, 9600, 500}},
    {"jet_b", &DevicesConfig::jet_b, {0, 9600, 500}},
    {"laser_profiler", &DevicesConfig::laser_profiler, {24691, 0, 0}},
    {"lamp", &DevicesConfig::lamp, {0, 19200, 0}},
    {"robot", &DevicesConfig::robot, {4096, 0, 0}},
    {"valve_a", &DevicesConfig::valve_a, {0, 115200, 0}},
    {"valve_b", &DevicesConfig::valve_b, {0, 115200, 0}},
    {"laser_point", &DevicesConfig::laser_point, {0, 115200, 0}},
    {"heater", &DevicesConfig::heater, {0, 9600, 0}},
    {"camera", &DevicesConfig::camera, {}},
    {"gas", &DevicesConfig::gas, {0, 19200, 0}},
};

/// Processes of a run that are no instrument's, and that may be on another computer than the launcher.
inline constexpr std::string_view kMovableNodes[] = {"surface_mapper", "controller",   "droplet_estimator",
                                                     "droplet_watch",  "path_planner", "flow_estimator"};

struct RunConfig {
  std::string name = "print";
  double time_scale = 1.0;        ///< live: node time runs this many times faster than wall time, 1..10
  double lease_s = 0.3;           ///< wall time
  double safety_period_s = 0.05;  ///< wall time between leases
  double clock_slack_ms = 20.0;   ///< most by which the clock of another host may be unknown
};

/// Computers on which processes of the run are, beside the launcher's.
struct HostsConfig {
  std::map<std::string, std::string>
      address;  ///< by name: its address for ssh, and perhaps the place of firn there
  std::map<std::string, std::string> of_node;  ///< name of each node's host; empty: the launcher's computer
};

struct Experiment {
  RunConfig run;
  LabConfig lab;
  GridSpec grid{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  PartConfig part;
  GeometryConfig geometry;
  ModelConfig model;
  ActuationConfig actuation;
  ControlConfig control;
  EstimatorConfig estimator;
  ProcessConfig process;
  StageConfig stage;
  JetConfig jet;
  JetBConfig jet_b;
  LaserProfilerConfig laser_profiler;
  LampConfig lamp;
  AerosolLabConfig aerosol;
  GasConfig gas;
  CameraConfig camera;
  droplet::WatchOptions watch;
  IceConfig ice;
  RobotConfig robot;
  ValveLineConfig valve_a, valve_b;
  LaserPointConfig laser_point;
  HeaterConfig heater;
  FlowConfig flow;
  CalibrationConfig calibration;
  PlantConfig plant;
  BusConfig bus;
  DevicesConfig devices;
  HostsConfig hosts;
  OwnPrograms own_programs;

  // Out of line: the constructors of all parts would be compiled again in each of a hundred sources.
  Experiment();
  Experiment(const Experiment& other);
  Experiment(Experiment&& other) noexcept;
  Experiment& operator=(const Experiment& other);
  Experiment& operator=(Experiment&& other) noexcept;
  ~Experiment();
};

/// Returns true if the lab has a second nozzle with its jet: for a part of two inks, or to measure the
/// position of nozzle B.
bool has_two_jets(const Experiment& experiment);

/// Returns true if a node of the channel table takes part in an experiment. The nodes of the lab's row
/// (config/labs.h) take part, some only if the experiment requires them. Nodes that no lab names (launcher,
/// recorder) always take part.
bool takes_part(const Experiment& experiment, std::string_view node);

/// Ignores keys that only earlier versions had: the text may be a recorded one.
/// @throws ConfigError: file, line, key, value, unit and limit; for an unknown key also the nearest known
/// one.
Experiment parse_experiment(const std::string& toml_text, const std::string& file_name);

/// The same of a text that dump() wrote, perhaps in an earlier version, for the use for which it was checked
/// then: a lab whose instruments alone are calibrated needs no part, for example.
Experiment parse_recorded_experiment(const std::string& toml_text, const std::string& file_name,
                                     const std::vector<std::string>& overrides = {});

/// Returns lab.kind of a text that may be older than its other keys; of one that cannot be read, or of an
/// unknown lab, the default.
std::string lab_kind_in(const std::string& toml_text);

/// `overrides`: "a.b=value" as of --set, applied in order after the file. A leading `include =
/// "../labs/x.toml"` is resolved relative to the file by the caller, who hands in the texts from base to
/// leaf. A path in a text is relative to its file's folder, and in the result to the last file's.
Experiment parse_experiment(const std::vector<std::pair<std::string, std::string>>& named_texts,
                            const std::vector<std::string>& overrides);

struct ConfigError;
/// Returns every mistake of the texts, in the order of the lines; where no value is wrong in itself, every
/// rule between keys that is broken.
std::vector<ConfigError> mistakes_of(const std::vector<std::pair<std::string, std::string>>& named_texts,
                                     const std::vector<std::string>& overrides);

/// Returns every field of the experiment's kind of lab with its value, in table order. A run keeps this text,
/// and nodes are built from it. parse_experiment(dump(e)) == e, and equal experiments have equal dumps.
std::string dump(const Experiment& experiment);

/// A key whose values differ, with both values.
struct ConfigDifference {
  std::string key, a, b;
};
std::vector<ConfigDifference> differences(const Experiment& a, const Experiment& b);

}  // namespace firn
