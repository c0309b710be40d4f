#include "core/vision/flight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::vision {
namespace {

constexpr double kAir_kg_m3 = 1.204, kViscosity_Pa_s = 1.81e-5, kDroplet_kg_m3 = 1000.0;
constexpr int kSteps = 400;
constexpr double kMaxTimes = 50.0;  // of the time without air

// x^(11/16) by square roots, which give the same bytes on every machine.
double power_11_16(double x) {
  const double half = std::sqrt(x), eighth = std::sqrt(std::sqrt(half));
  return half * eighth * std::sqrt(eighth);
}

double deceleration(double v_m_s, double diameter_m) {
  if (diameter_m <= 0.0) return 0.0;
  const double reynolds = kAir_kg_m3 * v_m_s * diameter_m / kViscosity_Pa_s;
  return v_m_s * 18.0 * kViscosity_Pa_s / (kDroplet_kg_m3 * diameter_m * diameter_m) *
         (1.0 + 0.15 * power_11_16(reynolds));
}

}  // namespace

double flight_time_s(const Flyer& flyer, double gap_mm) {
  if (!(flyer.velocity_mm_s > 0.0) || !(gap_mm > 0.0)) return 0.0;
  const double d = flyer.diameter_mm * 1e-3, gap_m = gap_mm * 1e-3;
  double v = flyer.velocity_mm_s * 1e-3;
  const double back_s = std::max(0.0, flyer.at_s) / kSteps;  // to the nozzle, where it was faster
  for (int n = 0; n < kSteps && back_s > 0.0; ++n) {
    const double middle = v + 0.5 * back_s * deceleration(v, d);
    v += back_s * deceleration(middle, d);
  }
  const double step_s = gap_m / v / kSteps;
  double fallen_m = 0.0;
  for (int n = 0; n < int(kMaxTimes) * kSteps; ++n) {
    const double middle = v - 0.5 * step_s * deceleration(v, d), next_m = fallen_m + middle * step_s;
    if (next_m >= gap_m) return step_s * (n + (gap_m - fallen_m) / (next_m - fallen_m));
    fallen_m = next_m;
    v -= step_s * deceleration(middle, d);
    if (!(v > 0.0)) break;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace firn::vision
