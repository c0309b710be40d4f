// Computes the calibrations of firn calibrate: commands a lab's instruments, collects their readings, and
// hands them to estimators/calibration [Barnett 2012, 2.2, 5.2.1, 6.1]. The true values of plant.* are
// unknown to this code.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/experiment.h"
#include "estimators/calibration/robust_fit.h"

namespace firn {

struct LabCalibrationOptions {
  int repeats = 0;                     ///< passes or weighings of a kind; 0 = the calibration's own
  std::vector<double> speeds_mm_s;     ///< of the passes; empty = its own
  std::vector<double> frequencies_hz;  ///< flow-curve; empty = 20 up to 500 Hz [6.1]
  std::vector<double> dwells_us;       ///< jet, first round; empty = 0.4 to 2 times the lab's
  std::vector<double> voltages_v;      ///< jet; empty = 0.6 to 1.6 times the lab's
  double velocity_m_s = 0.0;           ///< jet: wanted; 0 = the middle of the watch's band
  int material = 0;                    ///< valve-latency, flow-curve: 0 water, 1 scaffold
  int rounds = 1;          ///< level-table: > 1 = an operator turns as instructed and the lab measures again
  std::uint64_t seed = 1;  ///< of the passes' starts and of the order of actions
  std::function<void(double share)> progress = {};
  /// flow-curve on real ports: reads the balance; as CalibrationLab::Weigh.
  std::function<double(int material, int weighing)> weigh = {};
};

/// Holds a key of the lab file with its calibrated value.
struct FoundKey {
  std::string section, key, unit;
  std::vector<double> value, ci95_half_width;  ///< one entry, or those of an array
  std::vector<double> believed;
  int digits = 4;
  bool list = false;
  double tolerance = 0.0;  ///< wider intervals are refused; 0 = all are accepted
};

struct ResidualPlot {
  std::string x_name, y_name;
  struct Group {
    std::string label;
    std::vector<double> x, y;
  };
  std::vector<Group> groups;
};

struct LabCalibration {
  std::string what;            ///< "laser-offset"
  std::vector<FoundKey> keys;  ///< for the lab file
  std::vector<std::pair<std::string, calibration::Estimate>>
      also;                                         ///< found besides, with its unit in the name
  std::vector<std::string> lines;                   ///< instructions and their grounds
  bool level = false;                               ///< level-table: the points lie within the tolerance
  std::vector<double> foot_lift_mm, screw_lift_mm;  ///< and the turns until then, in all rounds
  ResidualPlot plot;
  std::string picture;  ///< SVG in the place of the residuals' plot; empty: none
  int data = 0, outliers = 0;
  double residual_std = 0.0;
  std::string residual_unit;
  double lab_s = 0.0;  ///< of the lab's own time
};

// @throws calibration::Unidentifiable: the data do not determine the value, or not within the thesis's
// tolerance; ConfigError, std::invalid_argument, std::runtime_error: a lab or an act that failed

/// Computes the spot's place in the flange's frame, within 0.2 mm: passes both ways over the block of
/// calibration.jig_* in x and y, at two yaws.
LabCalibration calibrate_laser_offset(const Experiment& experiment, const std::string& machine_toml,
                                      const LabCalibrationOptions& options);
/// Computes the latency within 2 ms: fast passes both ways over two sides of the block, at any place.
LabCalibration calibrate_laser_latency(const Experiment& experiment, const std::string& machine_toml,
                                       const LabCalibrationOptions& options);
/// Computes the turns from single readings at calibration.level_x_mm x level_y_mm: feet until the points lie
/// within 0.5 mm, then screws until 0.2 mm.
LabCalibration calibrate_table(const Experiment& experiment, const std::string& machine_toml,
                               const LabCalibrationOptions& options);
/// Computes the latency within 2 ms: drops laid both ways at two speeds, found again by the laser.
LabCalibration calibrate_valve_latency(const Experiment& experiment, const std::string& machine_toml,
                                       const LabCalibrationOptions& options);
/// Computes the flow within 2 %: drops of one frequency after the other into a cup, weighed.
LabCalibration calibrate_flow_curve(const Experiment& experiment, const std::string& machine_toml,
                                    const LabCalibrationOptions& options);
/// Computes the waveform: the dwell time of the fastest droplets within 1 us, in two rounds of strobe sweeps,
/// and the whole volts nearest to the wanted velocity. The second pulse keeps its ratios to the first.
LabCalibration calibrate_jet(const Experiment& experiment, const LabCalibrationOptions& options);

// For the above.
namespace lab_calibrations {
/// Returns the experiment with a simulated surface of this size about (x, y): surface that is not printed on
/// need not be simulated.
Experiment with_field(Experiment experiment, double x_mm, double y_mm, double width_mm, double depth_mm);
/// Returns the experiment with the block on the table, unless it has blocks.
Experiment with_jig(Experiment experiment);
/// @throws calibration::Unidentifiable: an interval wider than its tolerance
void check_intervals(const LabCalibration& calibration);
}  // namespace lab_calibrations

}  // namespace firn
