// One experiment: part, model, controller, lab and plant, as plain structs. Defaults are Lu's ink-jet lab.
// config/fields.cpp names every field with its unit, range and meaning; parser, resolved dump and
// docs/configuration.md come from that one table.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "config/ice.h"
#include "core/grid/grid.h"
#include "core/grid/shapes.h"
#include "core/grid/solids.h"

namespace firn {

struct PartConfig {
  ShapeSpec shape;              ///< shape.kind "height_map" takes the image instead
  std::string image;            ///< PNG, path relative to the experiment file
  double image_white_mm = 0.4;  ///< height of the brightest grey value
};

struct GeometryConfig {  ///< the part inside a block of support; the block is PartConfig's
  SolidSpec solid;       ///< kind "none": one ink
  std::string images;    ///< folder of PNG layers, path relative to the experiment file
  double image_pitch_z_mm = 0.0076;
  std::string mesh;  ///< STL, PLY, OBJ or 3MF, path relative to the experiment file; middle of the grid
  double mesh_scale_xy = 1.0;  ///< a flat lab prints a flat picture of a body
  double mesh_scale_z = 1.0;
  double mesh_z_mm = 0.0;  ///< height of its lowest point
  double judge_above_layers =
      0.0;  ///< where a cell's ink is judged, in layers h1 + 4 h2 + 4 h3 above its surface
};

struct ModelConfig {  ///< what the controllers believe [Lu 2015, Table I]
  double h1_mm = 0.0044;
  double h2_mm = 0.0006;
  double h3_mm = 0.0002;
  double g1_mm = 0.0044;  ///< two inks: the support's
  double g2_mm = 0.0006;
  double g3_mm = 0.0002;
  std::string border = "lose";  ///< "lose" or "keep"
};

struct OpenLoopConfig {
  int layers = 0;  ///< 0 = per cell from the target; else that many full layers
};

struct SmfConfig {  ///< [Barnett, (5.1), (5.2)]
  double kp = 1.0;
  double ki_star = 0.33;
  double kd_star = 0.03;
  double output_limit = 1.0;           ///< |u'| in layers
  double integral_limit = 2.0;         ///< in layers
  double layer_height_mm = 0.0;        ///< nominal layer; 0 = h1 + 4 h2 + 4 h3
  int max_drops = 2;                   ///< per cell and layer
  std::string rounding = "diffusion";  ///< "nearest", "diffusion" or "carry"
  double speed_range = 0.3;            ///< ice: the path speed stays within this share of nominal
  std::string version =
      "speed";  ///< ice: "speed" (c-controller, (5.8)) or "frequency" (nu-controller, (6.3))
};

struct ForeseeConfig {  ///< ice, scheme smf_foresee; gains are shares of an unforeseen error
  double kp = 1.0;
  double flow_gain = 0.7;  ///< of the mean over all of a material that is taken for lasting
  double zone_gain = 0.3;  ///< of a zone's mean beyond that
  double zone_mm = 1.0;    ///< a zone: one material, so wide a band of distances to its border
  double wide_gain = 0.1;  ///< of what is wider than wide_mm, beyond the zones
  double wide_mm = 9.0;
  double narrow_gain = 1.0;  ///< of what is narrower than narrow_mm that is answered: liquid levels itself
  double narrow_mm = 5.0;
};

struct ThresholdConfig {         ///< after Cohen and Lipson [7 of Lu 2015]
  double threshold_mm = 0.0;     ///< 0 = half a layer
  double layer_height_mm = 0.0;  ///< nominal layer; 0 = h1 + 4 h2 + 4 h3
};

struct AlphaStep {
  int from_layer = 1;
  double alpha = 1.0;
};

struct MpcConfig {                ///< [Lu 2015, (8), IV-C]
  std::string method = "greedy";  ///< "greedy", "descent", "strip_dp" or "certified"
  int strip_rows = 3;
  int anneal_sweeps = 100;
  int horizon = 1;
  std::string error = "absolute";  ///< "absolute", "square" or "square_mean"
  std::vector<AlphaStep> alpha = {{1, 1.0}};
  int subset = 16;  ///< M, points tried together
  std::int64_t max_evaluations = 20'000'000;
  int max_drops = 1;
  double finish_layers = 0.0;  ///< the part is printed to so many layers below its target first; 0 = at once
  double min_improvement_mm =
      0.0;  ///< the print ends when the best layer betters printing nothing by no more
  std::uint64_t seed = 1;
};

struct PatternConfig {          ///< scheme "pattern" [Lu 2015, III-A, V-C]
  std::string kind = "random";  ///< "random", "identification" or "squares"
  int layers = 0;               ///< 0 = as many full layers as the highest cell needs
  double fill = 0.5;
  int spacing_cells = 6;
  int largest_square = 6;
  int square_step = 2;
  std::uint64_t seed = 1;
};

struct RegistrationConfig {  ///< scheme "registration": marks of both nozzles, to measure where the second
                             ///< stands
  int layers = 5;            ///< droplets on each mark
  int spacing_cells = 16;    ///< between marks; those of A and B alternate
};

struct ControlConfig {
  std::string scheme = "mpc";       ///< a name of core/control's table
  int max_layers = 200;             ///< the print stops for the operator beyond this
  double smoothing = 0.0;           ///< 1 = robust DCT smoothing with automatic parameter, 0 = raw map
  std::string adapt_model = "off";  ///< "on": h1..h3 of HEIGHT_MODEL take the place of model.h1_mm..h3_mm
  std::string height_estimate =
      "map";  ///< "kalman": the map blended with what the executed droplets must have added
  double droplet_scatter = 0.06;  ///< relative standard deviation of a droplet, until droplet_estimator tells
  std::string droplet_factors =
      "off";                ///< "on", "together": learned inside the part and on its rim; rising together
  double noise_gate = 2.0;  ///< end when a layer would answer no more than this many noise_std per droplet
  OpenLoopConfig open_loop;
  SmfConfig smf;
  ForeseeConfig foresee;
  ThresholdConfig threshold;
  MpcConfig mpc;
  PatternConfig pattern;
  RegistrationConfig registration;
};

struct EstimatorConfig {         ///< what learns from the layers while they are printed
  std::string droplets = "off";  ///< "on": droplet_estimator takes part and publishes HEIGHT_MODEL
  int window_layers = 10;
  double prior_std = 0.5;      ///< relative, of each of h1..h3 about model.h1_mm..h3_mm
  int max_evaluations = 60;    ///< of the objective, per layer and round
  double memory_layers = 0.0;  ///< a layer's weight falls by 1 / e in so many; 0 = nothing is forgotten
};

struct ProcessConfig {  ///< how a layer is printed
  double pass_speed_mm_s = 150.0;
  double scan_speed_mm_s = 15.0;
  double park_x_mm = -5.0;  ///< cure and idle pose
  double park_y_mm = -5.0;
  double nozzle_gap_mm = 1.0;
  double exposure_s = 0.5;
  int iris_percent = 80;
  int sub_patterns = 1;  ///< interlaced patterns of a layer, each cured before the next [Lu 2015, V-D.2]
  int max_rescans = 2;   ///< of one layer when the map is rejected
  double min_measured_fraction = 0.8;  ///< interlock I13
};

struct StageConfig {
  double counts_per_mm = 10000.0;
  double acceleration_mm_s2 = 5000.0;
  double max_speed_mm_s = 300.0;
  double x_min_mm = -50.0, x_max_mm = 150.0;
  double y_min_mm = -50.0, y_max_mm = 150.0;
  double z_min_mm = -10.0, z_max_mm = 50.0;
  int array_limit = 8192;
  double poll_moving_s = 0.1;
  double poll_idle_s = 1.0;
};

struct JetConfig {
  double dwell_us = 20.0, echo_us = 40.0, rise_us = 3.0, fall_us = 3.0, final_us = 3.0;
  double idle_v = 0.0, dwell_v = 20.0, echo_v = -20.0;
  int max_rate_hz = 2000;
};

struct JetBConfig {  ///< the jet of ink B; takes part only when has_two_jets()
  double offset_x_mm =
      20.0;  ///< its nozzle relative to the first jet's, as the lab believes: nozzle B stands
  double offset_y_mm =
      0.0;  ///< above the part point (x, y) when the stage stands at (x - offset_x, y - offset_y)
  double offset_z_mm = 0.0;  ///< how much higher the stage's z must be for the same gap
  JetConfig drive;           ///< its own waveform
};

struct LaserProfilerConfig {
  int points = 800;
  double dx_mm = 0.0;        ///< 0 = chosen so that the line covers the grid
  double offset_y_mm = 0.0;  ///< line relative to the nozzle
  double poll_s = 0.004;
};

struct LampConfig {
  double max_on_s = 20.0;  ///< interlock I9
};

struct PlantConfig {
  std::string model = "droplets";  ///< "droplets" (Firn's own physics) or "lu2015" (the paper's simulation)
  std::uint64_t seed = 1;
  double ratio_b = 1.0;    ///< two inks: volume of a support droplet by an object droplet
  double variation = 0.2;  ///< lu2015: upward variation of h1..h3, per droplet and layer
  double size_std = 0.03;  ///< droplets: relative volume scatter
  double placement_std_mm = 0.008;
  double missed_fraction = 0.002;
  double satellite_fraction = 0.01;
  double drift = 0.1;           ///< slow relative flow drift over a print
  double nozzle_b_x_mm = 20.0;  ///< where nozzle B truly stands, relative to nozzle A
  double nozzle_b_y_mm = 0.0;
  double sensor_noise_mm = 0.001;  ///< Lu V-B: 1 um
  double dropout_fraction = 0.005;
  IcePlantConfig ice;
};

struct BusConfig {
  double loss = 0.0;  ///< of received datagrams, for fault injection
  double duplicate = 0.0;
  double reorder = 0.0;
  double delay = 0.0;
  double delay_s = 0.02;  ///< wall time
  std::uint64_t seed = 0;
};

struct RunConfig {
  std::string name = "print";
  double time_scale = 1.0;        ///< live: node time runs this many times faster than wall time, 1..10
  double lease_s = 0.3;           ///< wall time
  double safety_period_s = 0.05;  ///< wall time between leases
};

struct Experiment {
  RunConfig run;
  LabConfig lab;
  GridSpec grid{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  PartConfig part;
  GeometryConfig geometry;
  ModelConfig model;
  ControlConfig control;
  EstimatorConfig estimator;
  ProcessConfig process;
  StageConfig stage;
  JetConfig jet;
  JetBConfig jet_b;
  LaserProfilerConfig laser_profiler;
  LampConfig lamp;
  IceConfig ice;
  RobotConfig robot;
  ValveLineConfig valve_a, valve_b;
  LaserPointConfig laser_point;
  HeaterConfig heater;
  FlowConfig flow;
  CalibrationConfig calibration;
  PlantConfig plant;
  BusConfig bus;
};

/// Whether the lab has a second nozzle with its jet: for a part of two inks, or to measure where it stands.
bool has_two_jets(const Experiment& experiment);

/// Whether the lab is the ice printer (config/ice.h).
bool is_ice(const Experiment& experiment);

/// Whether a node of the channel table takes part in an experiment: those of the lab's kind, jet_b only with
/// two jets, droplet_estimator only where it is asked for. What it does not know takes part: the launcher,
/// the recorder.
bool takes_part(const Experiment& experiment, std::string_view node);

/// @throws ConfigError: file, line, key, value, unit and limit; for an unknown key also the nearest known
/// one.
Experiment parse_experiment(const std::string& toml_text, const std::string& file_name);

/// `overrides`: "a.b=value" as of --set, applied in order after the file. A leading `include =
/// "../labs/x.toml"` is resolved relative to the file by the caller, who hands in the texts from base to
/// leaf.
Experiment parse_experiment(const std::vector<std::pair<std::string, std::string>>& named_texts,
                            const std::vector<std::string>& overrides);

/// Every field that the experiment's kind of lab has, with its value, in table order: what a run keeps and
/// what nodes are built from. parse_experiment(dump(e)) == e, and dump is the same bytes for equal
/// experiments.
std::string dump(const Experiment& experiment);

/// Keys whose values differ, as {key, a, b}.
struct ConfigDifference {
  std::string key, a, b;
};
std::vector<ConfigDifference> differences(const Experiment& a, const Experiment& b);

}  // namespace firn
