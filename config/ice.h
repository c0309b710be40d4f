// IceConfig and its neighbours hold the settings of the ice printer: a robot arm with two valves, a point
// laser and heaters [Barnett 2012, ch. 2, 5]. They apply if lab.kind is "ice". Defaults are the thesis's
// Cobra 600.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/heater/heater_config.h"
#include "drivers/laser_point/laser_point_config.h"
#include "drivers/robot/robot_config.h"
#include "drivers/valve/valve_drive_config.h"

namespace firn {

struct LabConfig {
  std::string kind = "inkjet";  ///< "inkjet", "ice" or "aerosol"
};

/// Nominal speeds of depositing and measuring one material: speeds at u = 0, before the motion limits.
struct IceMaterialConfig {
  double boundary_mm_s = 25.0;
  double fill_mm_s = 25.0;
  double measure_mm_s = 50.0;
};

struct IceConfig {
  // The printed part; file paths are relative to the experiment's folder.
  std::string mesh;        ///< STL, PLY, OBJ or 3MF
  std::string slice;       ///< settings of firn slice
  std::string paths;       ///< instead of mesh and slice: a path file that firn slice wrote
  std::string machine;     ///< machine of firn plan
  double height_mm = 0.0;  ///< layers above this height are omitted; 0 = the whole mesh

  double origin_x_mm = 260.0, origin_y_mm = -100.0,
         origin_z_mm = 20.0;        ///< of the part frame in the robot's base frame
  int interval_layers = 5;          ///< n_d
  double layer_height_mm = 0.24;    ///< Delta h_d
  double pitch_mm = 1.0;            ///< of the interval's maps
  double measure_spacing_mm = 4.0;  ///< between measurement paths
  double measure_offset_mm =
      0.0;              ///< of measurement paths from the edge of their material; 0 = as its first bead
  int map_samples = 1;  ///< a cell's height is the mean of n x n places of it; 1 = its centre
  std::string map_table =
      "off";  ///< "on": the bare table is measured before the first layer; the first interval answers its map
  std::string coverage = "window";  ///< flows make up for beads that overlap or leave spots, by means over 5
                                    ///< mm; "off": they do not
  IceMaterialConfig water, scaffold{25.0, 25.0, 125.0};

  double nozzle_gap_mm = 3.0;       ///< nozzle above the nominal surface
  double clearance_mm = 0.5;        ///< interlock I6: minimum gap between the nozzle and the newest map
  double hop_mm = 5.0;              ///< z of travel moves above the nozzle's height
  int max_saturated_intervals = 3;  ///< number of consecutive saturated intervals that stops the print
  double saturated_share = 0.5;     ///< of the part's cells, above which an interval counts as saturated
  double least_rise_share = 0.3;    ///< of the nominal rise of an interval; a material with less had no flow
  double max_time_slip_s = 0.016;   ///< interlock I7
  int max_pulses = 16384;           ///< of one list, else the path is split
};

using drivers::HeaterConfig;
using drivers::LaserPointConfig;
using drivers::RobotConfig;

/// One micro-solenoid valve with its line, as the lab believes it to be.
struct ValveLineConfig : drivers::ValveDriveConfig {
  double hz_per_mm3_s = 4.0;     ///< c_ff of (5.14); used while the table is empty
  std::vector<double> table_hz;  ///< the calibrated flow curve's rows, ascending
  std::vector<double> table_mm3_s;
};

struct FlowConfig {                  ///< flow_estimator and the use of its estimate
  std::string feed_forward = "off";  ///< "on": the estimated Q(nu) replaces the calibrated curve; "own:NAME":
                                     ///< that of OWN_FLOW_MODEL by that program
};

/// Truth of the simulated ice lab, which no controller reads.
struct IcePlantConfig {
  double field_x0_mm = 0.0, field_y0_mm = 0.0;        ///< part frame: low corner of the simulated surface
  double field_width_mm = 0.0, field_depth_mm = 0.0;  ///< 0 = round all paths
  double cell_mm = 0.3;
  double drift_water = 0.0, drift_sme = 0.0;  ///< relative change of the flow in the end
  double drift_spread = 0.0;                  ///< and one more, of either sign, by seed and valve
  double origin_dx_mm = 0.0, origin_dy_mm = 0.0, origin_dz_mm = 0.0;  ///< true origin beyond ice.origin
  double laser_dx_mm = 0.0, laser_dy_mm = 0.0,
         laser_dz_mm = 0.0;                         ///< true spot beyond the machine's tool_laser
  double valve_a_dx_mm = 0.0, valve_a_dy_mm = 0.0;  ///< true nozzle beyond the machine's tool_water
  double valve_b_dx_mm = 0.0, valve_b_dy_mm = 0.0;  ///< and tool_scaffold
  double tank_water_mm3 = 2e6, tank_sme_mm3 = 2e6;
  double debris_per_h = 0.4;
  double roughness = 0.28;                    ///< share of each layer's height that freezes rough
  std::vector<double> foot_mm, screw_mm;      ///< table: heights of 4 feet and 9 screws; empty = level
  double table_x_mm = 0.0, table_y_mm = 0.0;  ///< part frame: the table's middle
  double table_width_mm = 900.0, table_depth_mm = 400.0;  ///< along x and y
  double table_roughness_mm = 0.05;                       ///< its fixed unevenness, standard deviation
  std::vector<double> jig_mm;                             ///< blocks on it: x0, y0, x1, y1, height of each
  double start_delay_s = 0.012;                           ///< from the robot's signal to its motion
  double laser_delay_s = 0.0008;                          ///< from the signal to the first stored reading
  double valve_a_delay_s = 0.0011,
         valve_b_delay_s = 0.0011;  ///< from a pulse's tick to the middle of its liquid
  double flow_water_mm3_s = 200.0, flow_sme_mm3_s = 200.0;  ///< through the open valve
  double recovery_water = 0.4, recovery_sme = 0.4;  ///< a pulse right after another is shorter by this share
  double balance_std_mg = 1.0;                      ///< of a weighing
  std::string instruments = "protocols";  ///< or "programs": the robot's V+ text, the valves' firmware
};

/// Facts that the lab's calibrations use: positions of the table's feet and screws, the block laid on the
/// table, the cup and the balance.
struct CalibrationConfig {
  double jig_x_mm = 0.0, jig_y_mm = 0.0;  ///< the block's low corner, part frame
  double jig_width_mm = 30.0, jig_depth_mm = 20.0, jig_height_mm = 2.0;
  double table_x_mm = 0.0, table_y_mm = 0.0;  ///< the table's middle; feet at its corners, screws 3 x 3
  double table_width_mm = 900.0, table_depth_mm = 400.0;
  double foot_pitch_mm = 1.5, screw_pitch_mm = 0.8;  ///< lift per turn, clockwise
  std::vector<double> level_x_mm, level_y_mm;        ///< columns and rows of the levelling points; three each
  double cup_x_mm = 0.0, cup_y_mm = 0.0;             ///< part frame; must lie beside the simulated surface
  double density_water_mg_mm3 = 0.917, density_sme_mg_mm3 = 0.875;  ///< of a printed volume
};

}  // namespace firn
