// WorldConfig holds the parameters of a simulated world: grid, nature, instruments, one seed. All are plain
// numbers; ranges are checked by the reader of the configuration file and again by check().
#pragma once

#include <any>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/grid/grid.h"
#include "plant/config/ice_config.h"
#include "plant/options/natures.h"

namespace firn::plant {

/// Holds the parameters of one droplet on the surface. The footprint is a spherical cap on a thin wetting
/// film. Two shape numbers are calibrated once (docs/plant.md): an undisturbed droplet on a flat surface
/// raises the means of its own, side and corner cells by 4.4, 0.6 and 0.2 um at a pitch of 0.263256 mm [Lu
/// 2015, Table I].
struct DropletParams {
  double volume_mm3 = 5.37457e-4;  ///< 7.6 um x pitch^2 of cured ink, divided by 1 - cure_shrink
  double cap_radius_mm = 0.18;     ///< at landing; levels out to the footprint of 0.42 mm [Lu 2015, Table I]
  double film_radius_mm = 0.44;
  double film_share = 0.42;  ///< part of the volume in the film
  /// Ground this much below the footprint's mean gets twice its share. Assumed: neither calibrated nor
  /// published; it decides how much ink runs off a rim (docs/plant.md).
  double slope_bias_mm = 0.01;
  double levelling = 0.2;     ///< share of a height difference that flows to the next fine cell per step
  double run_share = 0.1;     ///< at most this share of a fine cell's liquid leaves through one side per step
  int levelling_steps = 1;    ///< steps on the footprint at each landing
  double cure_shrink = 0.02;  ///< share of the liquid's volume that the lamp removes
  int fine_cells = 3;         ///< fine cells per droplet pitch, 1..8
  int margin_cells = 3;       ///< droplet pitches of field around the grid
  double flow = 1.0;          ///< every volume times this: another waveform, another ink
  double spread = 1.0;        ///< both radii times this: an ink that wets more or less
  double radius_exponent =
      0.0;  ///< both radii times flow to this power; 1/3 keeps the contact angle, 0 the radii
  double size_scatter = 0.03;  ///< standard deviation of the volume, relative
  double placement_scatter_mm = 0.008;
  double flight_time_s =
      0.0;  ///< a droplet keeps the stage's speed while it falls; 0 = compensated by the lab
  double missed_probability = 0.002;
  int dead_row = -1;  ///< row of the grid that no droplet reaches; -1: none
  double satellite_probability = 0.01;
  double satellite_share = 0.04;  ///< of the droplet's volume
  double satellite_distance_mm = 0.12;
  bool operator==(const DropletParams&) const = default;
};

/// Returns a droplet as wide as the one that was measured, 413 um [Lu 2015, V-C, Fig. 18]: a paraboloid
/// without film, of the calibrated volume. Its radius grows with V^(1/3): a paraboloid meets the ground at
/// tan(theta) = 4 V / (pi R^3), and the ink decides theta.
DropletParams droplet413();

/// Holds the parameters of ink line and nozzle as an ODE (plant/inkjet/nozzle.h).
struct NozzleParams {
  bool drift = true;    ///< false: the factor is 1 for ever
  double step_s = 2.0;  ///< the ODE is advanced at most this often
  double pressure_tau_s = 20.0;
  double pressure_per_drop = 1.0e-5;
  double wetting_tau_s = 120.0;
  double wetting_per_drop = 5.0e-5;
  double wetting_effect = -0.01;
  double heating_tau_s = 300.0;
  double heating_per_drop_K = 3.3e-5;
  double heating_effect_per_K = 0.004;
  double wander_tau_s = 10.0;
  double wander_sigma = 0.1;  ///< standard deviation that the random wander reaches in the course of a print
  double wander_memory = 0.97;  ///< of its target from one layer to the next
  bool operator==(const NozzleParams&) const = default;
};

/// Holds the parameters of the paper's own simulation [Lu 2015, Eqs. (3)-(5), V-A].
struct Lu2015Params {
  double h1_mm = 0.0044, h2_mm = 0.0006, h3_mm = 0.0002;
  double variation = 0.2;    ///< v: h1..h3 all times (1 + v U[0,1]) per droplet per layer (errata, FIT)
  bool keep_border = false;  ///< false: ink that leaves the grid is lost
  bool operator==(const Lu2015Params&) const = default;
};

/// Holds the parameters of the line sensor, which measures profiles of the surface (plant/inkjet/sensor.h).
struct SensorParams : SensorOptions {
  double noise_mm = 0.001;          ///< white, per point
  double dropout_floor = 0.005;     ///< probability of no reading on level ground
  double dropout_slope_from = 0.5;  ///< |dz/dx| above which it grows
  double dropout_per_slope = 0.3;
  bool operator==(const SensorParams&) const = default;
};

struct StageParams {
  double counts_per_mm = 10000.0;
  std::array<double, 3> low_limit_mm{-100.0, -100.0, -50.0};
  std::array<double, 3> high_limit_mm{300.0, 300.0, 50.0};
  double max_speed_mm_s = 300.0;
  double ramp_rate_mm_s2 = 500.0;  ///< until RAMP RATE says otherwise
  double abort_rate_mm_s2 = 2000.0;
  double home_speed_mm_s = 20.0;
  std::int64_t latency_us = 300;
  std::int64_t idle_close_us = 0;          ///< the controller closes a silent socket; 0 = never
  int global_integers = 4096;              ///< parameter GlobalIntegers, at most 4096
  double scurve_percent = 0.0;             ///< S-shaped share of ramps until SCURVE says otherwise, 0 .. 100
  bool home_blocks = false;                ///< HOME keeps the interpreter busy until the axes are home
  bool terminal_needed = false;            ///< pulses leave only after PSOOUTPUT CONTROL
  std::string pulse_counter = "PSOCOUNT";  ///< the question that it answers; empty: none
  double servo_hz = 0.0;                   ///< of the motion along a path; 0: exact
  double servo_damping = 0.7, servo_feed_forward = 1.0;
  double position_error_mm = 1.0;  ///< that the controller takes for a fault, along a path
  std::int64_t settle_us = 0;      ///< from the end of a move until it is in position
  // Of a GRBL board.
  std::string kind = "ensemble";  ///< the word of devices.stage.kind
  int baud = 115200;
  bool laser_output = false;  ///< its laser output is wired to the jet
  double box_pitch_mm = 0.0;  ///< of the box that counts its Y steps; 0: there is none
};
struct JetParams {
  int baud = 9600;
  double max_rate_hz = 2000.0;  ///< a trigger sooner than this after the last droplet is not obeyed
  std::int64_t reset_us = 3'000'000;
  std::int64_t pulse_us = 550'000;
  std::string kind = "jetdrive";        ///< the word of jet.kind
  std::string trigger_on, trigger_off;  ///< its words for the external trigger; empty: it has none
  std::int64_t settle_us = 0;           ///< deaf for so long after its line was opened
  double max_v = 0.0;                   ///< a level beyond this abuses the head; 0: none does
  bool volume_by_pulse = false;         ///< droplets are as large as jet_volume_share() says
};
struct ProfilerParams {
  bool point = false;  ///< a point laser that the stage moves: points 1, dx_mm the width of a column
  int points = 800;
  double dx_mm = 0.0;  ///< 0: 1.15 x grid width / points, rounded up to 5 um
  double laser_offset_y_mm = 0.0, laser_offset_x_mm = 0.0;      ///< from the nozzle; in x of a point alone
  double error_x_mm = 0.0, error_y_mm = 0.0, error_z_mm = 0.0;  ///< truth beyond what it reports
  double head_x_mm = 0.0;  ///< part x of the head's centre, from which it counts x
  bool mirrored = false;   ///< its x grows towards smaller part x
  bool upside_down = false;
  double zero_mm = 0.0;  ///< its value at part height 0
  std::int64_t latency_us = 500;
  std::int64_t sampling_us = 100;  ///< from trigger to profile ready
};
struct LampParams {
  int baud = 19200;
  std::int64_t max_on_us = 60'000'000;
  std::int64_t warm_up_us = 1'000'000;  ///< from TON until it is ready
  double min_dose_s = 0.01;             ///< iris share x open time that cures a layer
};

/// Holds the jet as the camera sees it, and the camera's picture.
struct StrobeParams {
  double speed_m_s = 2.0, angle_deg = 0.0, jitter_us = 0.0, break_off_us = 50.0;
  int satellites = 0;
  double um_per_px = 2.5, nozzle_um = 300.0;
  int width_px = 400, height_px = 320;
  double blur_px = 1.0, noise = 0.006, light = 0.7, uneven = 0.2;
  int dirt = 4;
  int dead_before = 0;  ///< starts of the jetting that bring no droplet
  /// Rectangular pulse at which droplets are fastest; 0: the waveform does not act on them. They have
  /// speed_m_s at 20 V then, and do not leave the nozzle below threshold_v.
  double best_dwell_us = 0.0, threshold_v = 8.0;
  double nozzle_gap_mm =
      0.0;  ///< droplets fall so far at speed_m_s and keep the stage's speed; 0 = not at all
  bool operator==(const StrobeParams&) const = default;
};

class WorldLab;
class WorldRecord;
struct WorldConfig;

/// Holds one kind of simulated lab: its instruments' ports and the functions that make and check its world.
struct WorldKind {
  std::string_view name;
  std::span<const std::string_view> ports;
  void (*check)(const WorldConfig&);               ///< throws std::invalid_argument naming field and limit
  std::string (*fingerprint)(const WorldConfig&);  ///< of the part that a saved state must agree with
  std::unique_ptr<WorldLab> (*make)(const WorldConfig&, WorldRecord*);
};
extern const WorldKind kInkjetWorld;
extern const WorldKind kIceWorld;  ///< of WorldConfig, only the seed and `ice` count

struct WorldConfig {
  const WorldKind* kind = &kInkjetWorld;
  GridSpec grid{40, 40, 0.263256, 0.263256, 0.0, 0.0};
  std::uint64_t seed = 1;
  double host_scale =
      1.0;  ///< world seconds per second of the host's clock, in which watchdogs against a dead host run
  double line_speed =
      1.0;  ///< serial lines are faster by this: something else carries the bytes at their baud
  std::string model = "droplets";  ///< a word of kNatureNames, or a class in Python
  NatureOptions nature;            ///< parameters of that physics
  bool two_inks = false;           ///< a block of object and support ink is printed, with two jets
  double nozzle_b_x_mm = 20.0;     ///< true place of the second nozzle, relative to the first
  double nozzle_b_y_mm = 0.0;
  double ratio_b = 1.0;  ///< volume of a droplet of the support's ink, in droplets of the object's
  DropletParams droplet;
  NozzleParams nozzle;
  Lu2015Params lu2015;
  SensorParams sensor;
  NozzleFaults nozzle_faults;
  StageFaults stage_faults;
  StageParams stage;
  JetParams jet, jet_b;
  ProfilerParams profiler;
  LampParams lamp;
  StrobeParams strobe;
  IceWorldConfig ice;
  std::any own;  ///< configuration of a lab beyond these two
};

/// @throws std::invalid_argument naming the field and its limit.
void check(const WorldConfig& config);
void check_inkjet(const WorldConfig& config);

}  // namespace firn::plant
