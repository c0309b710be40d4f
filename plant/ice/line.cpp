#include "plant/ice/line.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn::plant {
namespace {

constexpr double kKelvin = 273.15, kReference_degC = 20.0;

// p [kPa] = orifice Q^2, Q in mm^3/s: Q / A is mm/s, 1 kPa = 1e3 Pa, rho v^2 / 2 with v in m/s.
double orifice(const IceLineParams& p) {
  const double area_mm2 = 0.25 * std::numbers::pi * p.nozzle_mm * p.nozzle_mm;
  return 0.5 * p.density_kg_m3 * 1e-6 * 1e-3 / (p.discharge * p.discharge * area_mm2 * area_mm2);
}

// Laminar loss is the rest of the tank's pressure at full flow after the nozzle's; 0 if the nozzle uses all.
double laminar_per_viscosity(const IceLineParams& p) {
  const double rest_kpa = p.tank_pressure_kpa - orifice(p) * p.full_flow_mm3_s * p.full_flow_mm3_s;
  return std::max(0.0, rest_kpa) / (viscosity_mm2_s(p, kReference_degC) * p.full_flow_mm3_s);
}

double solve(double orifice, double laminar, double pressure_kpa) {
  if (pressure_kpa <= 0.0) return 0.0;
  return 2.0 * pressure_kpa / (laminar + std::sqrt(laminar * laminar + 4.0 * orifice * pressure_kpa));
}

}  // namespace

double viscosity_mm2_s(const IceLineParams& p, double degC) {
  return p.viscosity_40c_mm2_s *
         std::exp(p.viscosity_b_K * (1.0 / (degC + kKelvin) - 1.0 / (40.0 + kKelvin)));
}

double open_flow_mm3_s(const IceLineParams& p, double pressure_kpa, double degC) {
  return solve(orifice(p), laminar_per_viscosity(p) * viscosity_mm2_s(p, degC), pressure_kpa);
}

void Wander::step(double keep, double draw) {
  value = keep * value + std::sqrt(std::max(0.0, 1.0 - keep * keep)) * draw;
  ++draws;
}

Line::Line(const IceLineParams& params, std::uint64_t seed, int number)
    : params_(params), seed_(seed), number_(std::uint32_t(number)), orifice_(orifice(params)) {
  set_slow({}, 0.0);
}

void Line::set_slow(const Slow& slow, double t_s) {
  laminar_ = laminar_per_viscosity(params_) * viscosity_mm2_s(params_, slow.degC);
  factor_ =
      (1.0 + slow.coil) * (1.0 + params_.drift * (1.0 - std::exp(-std::max(0.0, t_s) / params_.drift_tau_s)));
  empty_ = slow.empty;
}

double Line::flow(double share) const { return solve(orifice_, laminar_, params_.tank_pressure_kpa * share); }

double Line::jet_speed_mm_s() const {
  return std::max(1.0, flow(1.0) / (0.25 * std::numbers::pi * params_.nozzle_mm * params_.nozzle_mm));
}

// With an empty tank or a blocked line the pressure falls to 0 with the time constant of its recovery.
void Line::settle(double t_s) {
  const double goal = empty_ || blocked_ ? 1.0 : 0.0;
  sag_ = goal + (sag_ - goal) * std::exp(-std::max(0.0, t_s - last_s_) / params_.line_tau_s);
}

double Line::sag_of(double volume_mm3) const {
  return params_.line_drop * volume_mm3 / (params_.full_flow_mm3_s * params_.line_tau_s);
}

double Line::pulse(double t_s, double pulse_s) {
  const double since_s = std::max(0.0, t_s - last_s_), gap_s = std::max(0.0, t_s - closed_s_);
  settle(t_s);
  const double keep = std::exp(-since_s / params_.pulsation_tau_s);
  pulsation_.step(keep, random_normal({seed_, Purpose::kNozzleDrift, 1000 + number_,
                                       std::uint32_t(pulses_ >> 32), std::uint32_t(pulses_)}));
  const double open_s = pulse_s * (1.0 - params_.recovery_share * std::exp(-gap_s / params_.recovery_tau_s));
  const double volume_mm3 = flow(std::max(0.0, 1.0 - sag_)) * open_s * factor_ *
                            std::max(0.0, 1.0 + params_.pulsation * pulsation_.value);
  sag_ = std::min(1.0, sag_ + sag_of(volume_mm3));
  last_s_ = t_s;
  closed_s_ = t_s + pulse_s;
  ++pulses_;
  return volume_mm3;
}

double Line::held_open(double t_s, double open_s) {
  settle(t_s);
  last_s_ = t_s;
  closed_s_ = t_s + open_s;
  const double volume_mm3 = flow(std::max(0.0, 1.0 - sag_)) * open_s * factor_;
  sag_ = std::min(1.0, sag_ + sag_of(volume_mm3));
  return volume_mm3;
}

// The sag before a pulse of period P repeats: s = (s + k V) exp(-P / tau).
double Line::steady_pulse_mm3(double frequency_hz, double pulse_s) const {
  const double period_s = 1.0 / frequency_hz, fade = std::exp(-period_s / params_.line_tau_s);
  const double open_s =
      pulse_s *
      (1.0 - params_.recovery_share * std::exp(-std::max(0.0, period_s - pulse_s) / params_.recovery_tau_s));
  const double per_mm3 = params_.line_drop / (params_.full_flow_mm3_s * params_.line_tau_s);
  double volume_mm3 = 0.0;
  for (int n = 0; n < 60; ++n) {
    const double sag = per_mm3 * volume_mm3 * fade / (1.0 - fade);
    volume_mm3 = flow(std::max(0.0, 1.0 - sag)) * open_s * factor_;
  }
  return volume_mm3;
}

}  // namespace firn::plant
