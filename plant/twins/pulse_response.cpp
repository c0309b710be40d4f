#include "plant/twins/pulse_response.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn::plant {
namespace {

constexpr double kReference_v = 20.0;

}  // namespace

double jet_speed_m_s(const StrobeParams& jet, const JetPulse& p) {
  if (jet.best_dwell_us <= 0.0) return jet.speed_m_s;
  const double width_us = p.dwell_us + 0.5 * (p.rise_us + p.fall_us);
  const double amplitude_v =
      std::abs(p.volts * std::sin(0.5 * std::numbers::pi * width_us / jet.best_dwell_us));
  return std::max(0.0, jet.speed_m_s * (amplitude_v - jet.threshold_v) / (kReference_v - jet.threshold_v));
}

double jet_volume_share(const StrobeParams& jet, const JetPulse& p) {
  return std::max(0.0, (std::abs(p.volts) - jet.threshold_v) / (kReference_v - jet.threshold_v));
}

}  // namespace firn::plant
