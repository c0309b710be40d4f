// Holds planted cases for the calibrations of the ice lab: an experiment whose simulated lab differs from the
// configured one, and the truth that a calibration must find from measured data.
#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <string>
#include <vector>

#include "config/include.h"
#include "core/grid/random.h"
#include "plant/ice/line.h"
#include "plant/world/setup.h"
#include "studies/calibrate/lab_calibrations.h"

namespace firn::planted {

struct IceLab {
  Experiment experiment;
  std::string machine_toml;
};

inline IceLab shipped_ice_lab(const std::filesystem::path& source) {
  IceLab lab{load_experiment(source / "labs/ice-cobra600.toml", {"ice.mesh=\"-\""}), ""};
  std::ifstream file(source / "labs/cobra600.toml");
  lab.machine_toml.assign(std::istreambuf_iterator<char>(file), {});
  return lab;
}

/// Computes the delay of the arm behind its command on a path's straight middle: start delay and servo lag.
inline double arm_lag_s(const Experiment& e) {
  const plant::IceArmParams a = plant::world_config(e).ice.arm;
  return a.start_delay_s + 0.5 * a.start_jitter_s +
         2.0 * a.servo_damping / (2.0 * std::numbers::pi * a.servo_hz);
}
/// A reading is that of the middle of its averaging window, which ends as it is stored.
inline double laser_latency_s(const Experiment& e) {
  const double window_s = e.laser_point.sampling_us * 1e-6 * std::pow(4.0, e.laser_point.averaging);
  return e.plant.ice.laser_delay_s - 0.5 * window_s - arm_lag_s(e);
}
/// @param gap_mm from the nozzle to the table
inline double valve_latency_s(const Experiment& e, int material, double gap_mm) {
  const plant::IceWorldConfig c = plant::world_config(e).ice;
  plant::Line line(c.line[std::size_t(material)], 1, material);
  line.set_slow({20.0, 0.0, false}, 0.0);
  return c.valve[std::size_t(material)].trigger_delay_s + c.line[std::size_t(material)].open_delay_s +
         gap_mm / line.jet_speed_mm_s() - arm_lag_s(e);
}
/// Mean flow of a steady line at a constant frequency on the list's raster [mm^3/s].
/// @param mean_hz pulse rate that has warmed the coil
inline double flow_mm3_s(const Experiment& e, int material, double hz, double mean_hz) {
  plant::IceLineParams p = plant::world_config(e).ice.line[std::size_t(material)];
  p.pulsation = 0.0;
  plant::Line line(p, 1, material);
  line.set_slow({e.heater.tip_degC, p.coil_gain * mean_hz / 500.0, false}, 0.0);
  double sum = 0.0;
  const int n = int(4.0 * hz);
  for (int k = 0; k < 2 * n; ++k) {
    const double v = line.pulse(0.002 * std::floor((k + 0.5) / hz / 0.002 + 1e-6),
                                1e-6 * (material ? e.valve_b : e.valve_a).pulse_us);
    if (k >= n) sum += v;
  }
  return sum / n * hz;
}

/// Returns the unknown values of the lab: places, delays, flow and table of case n.
inline Experiment plant_case(const IceLab& lab, std::uint64_t n) {
  Experiment e = lab.experiment;
  RandomStream random(n, Purpose::kTest, 77);
  IcePlantConfig& p = e.plant.ice;
  e.plant.seed = n;
  p.laser_dx_mm = random.uniform(-3.0, 3.0);
  p.laser_dy_mm = random.uniform(-3.0, 3.0);
  p.start_delay_s = random.uniform(0.0, 0.04);
  p.laser_delay_s = random.uniform(0.0, 0.02);
  p.valve_a_delay_s = random.uniform(0.0, 0.02);
  p.valve_b_delay_s = random.uniform(0.0, 0.02);
  p.flow_water_mm3_s = random.uniform(150.0, 240.0);
  p.flow_sme_mm3_s = random.uniform(150.0, 240.0);
  p.recovery_water = random.uniform(0.0, 0.5);
  p.recovery_sme = random.uniform(0.0, 0.5);
  p.foot_mm.clear();
  for (int f = 0; f < 4; ++f) p.foot_mm.push_back(random.uniform(-3.0, 3.0));
  return e;
}

/// Besides, nine screws up to 0.5 mm off.
inline void plant_screws(Experiment& e, std::uint64_t n) {
  RandomStream random(n, Purpose::kTest, 78);
  for (int s = 0; s < 9; ++s) e.plant.ice.screw_mm.push_back(random.uniform(-0.5, 0.5));
}

/// The true height of the table but for its unevenness: feet at the corners, bilinear between; screws,
/// parabolas between.
inline double table_mm(const Experiment& e, double x_mm, double y_mm) {
  const IcePlantConfig& p = e.plant.ice;
  const double u = 2.0 * (x_mm - p.table_x_mm) / p.table_width_mm,
               v = 2.0 * (y_mm - p.table_y_mm) / p.table_depth_mm;
  double z = 0.25 * ((1 - u) * (1 - v) * p.foot_mm[0] + (1 + u) * (1 - v) * p.foot_mm[1] +
                     (1 - u) * (1 + v) * p.foot_mm[2] + (1 + u) * (1 + v) * p.foot_mm[3]);
  const double along_x[] = {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)},
               along_y[] = {0.5 * v * (v - 1.0), 1.0 - v * v, 0.5 * v * (v + 1.0)};
  for (std::size_t s = 0; s < p.screw_mm.size(); ++s) z += along_x[s % 3] * along_y[s / 3] * p.screw_mm[s];
  return z;
}

/// One estimate beside its planted value.
struct Judged {
  double error = 0.0, ci95_half_width = 0.0;
  bool inside() const { return std::abs(error) <= ci95_half_width; }
};

inline std::vector<Judged> judge_offset(const Experiment& e, const LabCalibration& c) {
  return {{c.keys[0].value[0] - e.plant.ice.laser_dx_mm, c.keys[0].ci95_half_width[0]},
          {c.keys[1].value[0] - e.plant.ice.laser_dy_mm, c.keys[1].ci95_half_width[0]}};
}
inline std::vector<Judged> judge_laser_latency(const Experiment& e, const LabCalibration& c) {
  return {{c.keys[0].value[0] - laser_latency_s(e), c.keys[0].ci95_half_width[0]}};
}
inline std::vector<Judged> judge_valve_latency(const Experiment& e, const LabCalibration& c, int material,
                                               double gap_mm) {
  return {{c.keys[0].value[0] - valve_latency_s(e, material, gap_mm), c.keys[0].ci95_half_width[0]}};
}
/// Relative.
inline std::vector<Judged> judge_flow(const Experiment& e, const LabCalibration& c, int material) {
  std::vector<Judged> out;
  for (std::size_t n = 0; n < c.keys[0].value.size(); ++n) {
    const double truth = flow_mm3_s(e, material, c.keys[0].value[n], c.also[0].second.value);
    out.push_back({c.keys[1].value[n] / truth - 1.0, c.keys[1].ci95_half_width[n] / truth});
  }
  return out;
}
/// Height of the fitted table at its points' middle; slopes as heights over 100 mm. The table is as it was
/// turned.
inline std::vector<Judged> judge_table(Experiment e, const LabCalibration& c) {
  for (std::size_t f = 0; f < c.foot_lift_mm.size(); ++f) e.plant.ice.foot_mm[f] += c.foot_lift_mm[f];
  for (std::size_t s = 0; s < e.plant.ice.screw_mm.size(); ++s) e.plant.ice.screw_mm[s] += c.screw_lift_mm[s];
  const CalibrationConfig& k = e.calibration;
  const double x = k.level_x_mm[k.level_x_mm.size() / 2], y = k.level_y_mm[k.level_y_mm.size() / 2], d = 50.0;
  const auto& a = c.also;
  return {{a[0].second.value - table_mm(e, x, y), a[0].second.ci95_half_width},
          {100.0 * a[1].second.value - table_mm(e, x + d, y) + table_mm(e, x - d, y),
           100.0 * a[1].second.ci95_half_width},
          {100.0 * a[2].second.value - table_mm(e, x, y + d) + table_mm(e, x, y - d),
           100.0 * a[2].second.ci95_half_width}};
}

}  // namespace firn::planted
