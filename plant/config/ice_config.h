// IceWorldConfig holds the true parameters of the simulated ice printer [Barnett 2012]: nature's and the
// instruments', with one seed. The controllers have parameters of their own. Sources are in
// docs/plant-ice.md. Lengths are in mm, times in s, positions in the part frame unless said otherwise: z up
// from the table, robot base frame = part + origin.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace firn::plant {

class IceWires;
class ValveBox;

/// Holds the raster of fine cells that represents the surface; drops that land elsewhere are lost (and
/// counted).
struct IceFieldParams {
  double cell_mm = 0.3;                        ///< 0.15 .. 0.6
  double x0_mm = -64.0, y0_mm = -64.0;         ///< low corner of the low cell, part frame
  double width_mm = 128.0, height_mm = 128.0;  ///< 5 .. 500; cover part, scaffold and 4 mm around
};

/// Holds the spreading parameters of a drop before it is solid. Index 0 water, 1 SME.
struct IceBeadParams {
  double pool_mm = 0.24;      ///< thickness at which liquid on level ground stops spreading, 0.05 .. 1
  double deepest_mm = 0.40;   ///< at most this much of one drop stays in a low place, 0.05 .. 2
  double edge_mm = 0.60;      ///< ground this much below the liquid is an edge, where it hangs on, 0.1 .. 5
  double spill = 1.60;        ///< spilt volume, in shares of the volume beyond an edge, 0 .. 3
  double scatter_mm = 0.20;   ///< landing point of a drop about the jet's axis, standard deviation, 0 .. 2
  double wander_rad = 0.035;  ///< the jet's direction about the nozzle's axis, standard deviation, 0 .. 0.3
  double wander_tau_s = 0.4;  ///< 0.01 .. 100
};

/// Holds the parameters of one line from its tank to its valve. Index 0 water (valve_a), 1 SME (valve_b).
/// Volumes are of frozen material.
struct IceLineParams {
  double tank_pressure_kpa = 55.0;     ///< 1 .. 500
  double nozzle_mm = 0.191;            ///< 0.05 .. 1
  double viscosity_40c_mm2_s = 0.685;  ///< 0.1 .. 100
  double viscosity_b_K = 1939.0;       ///< nu = nu_40 exp(B (1/T - 1/313.15 K)), 0 .. 10000
  double density_kg_m3 = 998.0;        ///< 500 .. 2000
  double discharge = 0.80;             ///< of the nozzle's orifice, 0.3 .. 1
  double full_flow_mm3_s = 200.0;  ///< through the open valve at the tank's pressure and 20 degC, 10 .. 250
  double line_drop = 0.04;         ///< share of the tank's pressure lost in the tubing at full flow, 0 .. 0.5
  double line_tau_s = 0.030;       ///< compliance of the tubing refills with this time constant, 0.001 .. 10
  double recovery_share = 0.40;    ///< a pulse right after another is shorter by this share, 0 .. 0.9
  double recovery_tau_s = 0.0016;  ///< and that share fades with this time constant, 1e-4 .. 0.1
  double open_delay_s = 0.0011;  ///< from the end of the trigger's tick to the middle of the pulse, 0 .. 0.05
  double coil_gain = 0.20;       ///< flow + this at 500 Hz for ever, 0 .. 0.5
  double coil_tau_s = 240.0;     ///< 1 .. 10000
  double drift = 0.0;            ///< flow + this in the end, -0.3 .. 0.3
  double drift_tau_s = 7200.0;   ///< 1 .. 1e6
  double pulsation = 0.03;       ///< standard deviation of fast flow noise, 0 .. 0.3
  double pulsation_tau_s = 1.0;  ///< 0.01 .. 1000
  double tank_mm3 = 2.0e6;       ///< 0: empty from the start
  bool operator==(const IceLineParams&) const = default;
};

/// Holds the thermal parameters of the end effector in the freezer: sections (a) tip with the valves, (b)
/// laser, (c) conduit joint.
struct IceHeatParams {
  double ambient_degC = -20.0;  ///< -60 .. 30
  std::array<double, 3> capacity_J_K{150.0, 180.0, 160.0};
  std::array<double, 3> loss_W_K{0.22, 0.18, 0.26};  ///< to the freezer
  std::array<double, 2> link_W_K{0.50, 0.45};        ///< (a)-(b), (b)-(c)
  std::array<double, 3> heater_W{36.0, 24.0, 36.0};
  std::array<double, 3> set_degC{20.0, 22.0, 20.0};  ///< until the controller sets another, 0 .. 45
  double hysteresis_K = 1.0;                         ///< on below set - this, off above set + this, 0.1 .. 10
  double valve_J_per_pulse = 0.025;                  ///< 0 .. 1
  double freeze_degC = 0.0;                          ///< valve_a does not fire below this tip temperature
  double freeze_sme_degC = 5.0;                      ///< the same of valve_b
  double start_degC = 20.0;
};

struct IceTool {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 0.0;  ///< from the flange, x along its yaw, z up
  bool operator==(const IceTool&) const = default;
};

struct IceArmParams {
  double link_1_mm = 325.0, link_2_mm = 275.0;
  std::array<double, 3> origin_mm{260.0, -100.0, 20.0};  ///< of the part frame in the robot's base frame
  IceTool valve_a{0.1, 0.3, 0.0}, valve_b{-0.2, -8.2, 0.0};
  IceTool laser{30.0, -19.0, 0.0};   ///< the middle of its range, not its face
  double servo_hz = 20.0;            ///< of each joint's position loop, 2 .. 100
  double servo_damping = 1.0;        ///< 0.3 .. 2
  double cantilever_hz = 12.0;       ///< first bending mode of the end effector, 3 .. 60
  double cantilever_damping = 0.03;  ///< 0.001 .. 0.5
  std::array<double, 4> encoder{0.00045, 0.00072, 0.0015, 0.03125};  ///< per count: deg, deg, mm, deg
  double start_delay_s = 0.012;   ///< from the signal to the motion, 0 .. 0.1
  double start_jitter_s = 0.001;  ///< uniform, on top, 0 .. 0.05
  double clock_ppm = 20.0;        ///< of the robot's clock against the world's, -1000 .. 1000
  double slip_probability = 0.0;  ///< of a path that takes `slip_s` longer than planned
  double slip_s = 0.05;
  double brake_s = 0.15;  ///< from full speed to rest on BRAKE
  std::array<double, 4> low{-105.0, -150.0, 0.0, -360.0},
      high{105.0, 150.0, 210.0, 360.0};  ///< deg, deg, mm, deg
  std::int64_t latency_us = 2000;        ///< of a reply
  bool operator==(const IceArmParams&) const = default;
};

struct IceValveParams {  ///< firmware of a valve's controller
  bool firmware =
      false;  ///< the firmware itself (plant/twins/firmware_valve.h), or the twin written from FVB/1
  int baud = 115200;
  double clock_ppm = -18.0;  ///< -1000 .. 1000
  double trigger_delay_s = 0.0004;
};

struct IceLaserParams {
  int baud = 115200;
  double range_mm = 5.0;              ///< +- about the tool point
  double repeatability_mm = 0.00005;  ///< standard deviation
  double linearity = 0.0005;          ///< of the full range, at its ends
  double spot_mm = 0.03;
  double trigger_delay_s = 0.0008;  ///< controller, within 1 ms [5.2.1]
  double clock_ppm = 5.0;
  double ice_noise_mm = 0.015;       ///< on ice with the ice settings, at 50 mm/s
  double ice_dropout = 0.01;         ///< share without a value, the same
  double scaffold_noise_mm = 0.008;  ///< on SME with the SME settings, at 125 mm/s
  double scaffold_dropout = 0.002;
  double wrong_noise_mm = 0.25;  ///< with the settings of the other material
  double wrong_dropout = 0.35;
  double speed_power = 1.5;    ///< noise and drop-outs grow with (speed / the above)^this
  double slope_dropout = 0.6;  ///< more per unit of slope above 0.5
  bool operator==(const IceLaserParams&) const = default;
};

/// Holds a block on the table, for calibrations: sharp edges of known height.
struct IceJig {
  double x0_mm = 0.0, y0_mm = 0.0, x1_mm = 0.0, y1_mm = 0.0, top_mm = 0.0;
  bool operator==(const IceJig&) const = default;
};
struct IceTableParams {
  double width_mm = 900.0, depth_mm = 400.0, centre_x_mm = 0.0, centre_y_mm = 0.0;  ///< part frame
  std::array<double, 4> foot_mm{};  ///< heights at the corners (-x-y, +x-y, -x+y, +x+y), bilinear between
  std::array<double, 9>
      screw_mm{};              ///< and of the nine screws on top, row by row from -y, biquadratic between
  double roughness_mm = 0.05;  ///< a fixed pattern besides, standard deviation
  std::vector<IceJig> jigs;    ///< at most 16
  bool operator==(const IceTableParams&) const = default;
};

struct IceDisturbanceParams {
  double debris_per_h = 0.4;      ///< bumps that fall on the part, 0 .. 1000
  double debris_height_mm = 0.6;  ///< the maximum; uniform from 0.2 of it [5.6: d_p = 0.5 intervals]
  double debris_radius_mm = 1.5;
  double pattern = 0.015;     ///< frozen volume by place (trapped air, frost), standard deviation, 0 .. 0.2
  double pattern_mm = 40.0;   ///< its length
  double roughness = 0.28;    ///< share of each layer's height that freezes rough, new in every layer
  double roughness_mm = 2.5;  ///< its length
  double gap_mm = 3.0;        ///< clearance for which the jet's wander is stated
  bool operator==(const IceDisturbanceParams&) const = default;
};

/// Holds the balance beside the table and the densities of the material in its cup, which falls beside the
/// field.
struct IceBalanceParams {
  std::array<double, 2> density_mg_mm3{0.917, 0.875};  ///< of frozen volumes, 0.1 .. 10
  double std_mg = 1.0;                                 ///< of a weighing, 0 .. 1000
  double step_mg = 1.0;                                ///< of its display, 0.001 .. 1000
  bool operator==(const IceBalanceParams&) const = default;
};

struct IceProgramText {
  std::string file, text;  ///< file: as errors name it
};

/// Holds the V+ text that the robot's controller executes (plant/twins/vplus_robot.h).
struct IceRobotProgram {
  std::vector<IceProgramText> texts;  ///< empty: the twin that is written from FVP/1 (plant/twins/robot.h)
  int statements_per_tick = 160;      ///< 16 .. 1000000, plant/twins/vplus/machine.h
};

struct IceWorldConfig {
  IceRobotProgram robot;
  IceFieldParams field;
  std::array<IceBeadParams, 2> bead;
  std::array<IceLineParams, 2> line;
  IceHeatParams heat;
  IceArmParams arm;
  std::array<IceValveParams, 2> valve;
  /// Makes a valve's box of another kind than these, such as one whose binary runs in a simulated
  /// microcontroller; empty: `valve` says.
  std::function<std::unique_ptr<ValveBox>(int valve, const IceValveParams& params, IceWires& wires)>
      make_valve_box;
  bool heater_firmware = false;  ///< as IceValveParams::firmware, of plant/twins/firmware_heater.h
  IceLaserParams laser;
  IceTableParams table;
  IceDisturbanceParams disturbance;
  IceBalanceParams balance;
  IceWorldConfig();  ///< SME's own values at index 1
};

/// Takes from nature all that depends on when a path begins: warming coils, temperature, drift, wander from
/// path to path, debris, the end effector's swing after the move before. Prints of equal paths are equal
/// then, whatever their pauses.
void make_steady(IceWorldConfig& config);

/// @throws std::invalid_argument naming the field and its limit.
void check(const IceWorldConfig& config);

}  // namespace firn::plant
