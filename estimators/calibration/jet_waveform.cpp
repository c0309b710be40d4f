#include "estimators/calibration/jet_waveform.h"

#include <algorithm>
#include <cmath>

namespace firn::calibration {
namespace {

constexpr std::size_t kMinDwells = 6;
constexpr double kStandsOut = 5.0;  // standard deviations

double std_of(const JetSpeed& s) { return std::max(s.std_m_s, 1e-6); }

}  // namespace

const JetSpeed& fastest(std::span<const JetSpeed> speeds) {
  constexpr double kSure = 1.96;  // standard deviations
  return *std::ranges::max_element(speeds, {},
                                   [](const JetSpeed& s) { return s.velocity_m_s - kSure * std_of(s); });
}

double BestDwell::at(double dwell) const {
  const double u = (dwell - dwell_us.value) / half_width_us, q = u * u;
  return velocity_m_s.value - quadratic_m_s * q + quartic_m_s * q * q;
}

BestDwell fit_best_dwell(std::span<const JetSpeed> speeds) {
  if (speeds.size() < kMinDwells)
    throw Unidentifiable("droplets were seen at " + std::to_string(speeds.size()) + " dwell times only, " +
                         std::to_string(kMinDwells) + " are needed");
  const auto [low, high] = std::ranges::minmax(speeds, {}, &JetSpeed::dwell_us);
  const JetSpeed& top = fastest(speeds);
  const double half = 0.5 * (high.dwell_us - low.dwell_us);
  if (!(half > 0.0)) throw Unidentifiable("the dwell time: there is only one");
  double least = top.velocity_m_s;
  for (const JetSpeed& s : speeds) least = std::min(least, s.velocity_m_s);
  const double fall = std::max(top.velocity_m_s - least, 1e-3 * top.velocity_m_s);
  const std::vector<Parameter> parameters{{"the best dwell time", top.dwell_us, 0.05 * half, half},
                                          {"the velocity there", top.velocity_m_s, 0.1 * fall, 20.0 * fall},
                                          {"the velocity's fall beside it", fall, fall, 50.0 * fall},
                                          {"its fourth order", 0.0, fall, 50.0 * fall}};
  BestDwell b;
  b.half_width_us = half;
  b.fit = robust_fit(
      parameters, speeds.size(),
      [&](std::size_t i, const double* x, double* gradient) {
        const JetSpeed& s = speeds[i];
        const double u = (s.dwell_us - x[0]) / half, q = u * u, weight = 1.0 / std_of(s);
        gradient[0] = weight * (2.0 * x[2] * u - 4.0 * x[3] * u * q) / half;
        gradient[1] = weight;
        gradient[2] = -weight * q;
        gradient[3] = weight * q * q;
        return weight * (x[1] - x[2] * q + x[3] * q * q - s.velocity_m_s);
      },
      1.0);
  b.dwell_us = b.fit.parameters[0];
  b.velocity_m_s = b.fit.parameters[1];
  b.quadratic_m_s = b.fit.parameters[2].value;
  b.quartic_m_s = b.fit.parameters[3].value;
  const Estimate at_ends = b.fit.estimate(b.quadratic_m_s - b.quartic_m_s, {0.0, 0.0, 1.0, -1.0});
  if (!(at_ends.value > kStandsOut * at_ends.std))
    throw Unidentifiable("the velocity does not depend on the dwell time beyond its noise");
  return b;
}

VoltageLine fit_voltage(std::span<const JetSpeed> speeds, double wanted_m_s) {
  if (speeds.size() < kMinVoltages)
    throw Unidentifiable("droplets were seen at " + std::to_string(speeds.size()) + " voltages only, " +
                         std::to_string(kMinVoltages) + " are needed");
  const auto [low, high] = std::ranges::minmax(speeds, {}, &JetSpeed::volts);
  const double range = high.volts - low.volts, rise = high.velocity_m_s - low.velocity_m_s;
  if (!(range > 0.0 && rise > kStandsOut * std::hypot(std_of(low), std_of(high))))
    throw Unidentifiable("the velocity does not rise with the voltage beyond its noise");
  const double slope = rise / range, zero = low.volts - low.velocity_m_s / slope;
  const std::vector<Parameter> parameters{{"the threshold voltage", zero, 0.1 * range, 10.0 * range},
                                          {"the velocity per volt", slope, 0.1 * slope, 10.0 * slope}};
  VoltageLine line;
  line.fit = robust_fit(
      parameters, speeds.size(),
      [&](std::size_t i, const double* x, double* gradient) {
        const JetSpeed& s = speeds[i];
        const double weight = 1.0 / std_of(s);
        gradient[0] = -weight * x[1];
        gradient[1] = weight * (s.volts - x[0]);
        return weight * (x[1] * (s.volts - x[0]) - s.velocity_m_s);
      },
      1.0);
  line.threshold_v = line.fit.parameters[0];
  line.slope_m_s_v = line.fit.parameters[1];
  const double m = line.slope_m_s_v.value;
  line.volts = line.fit.estimate(line.threshold_v.value + wanted_m_s / m, {1.0, -wanted_m_s / (m * m)});
  return line;
}

}  // namespace firn::calibration
