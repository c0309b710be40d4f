#include "core/control/lines/visible_width.h"

#include <algorithm>
#include <cmath>

namespace firn::control {
namespace {

constexpr double kLn2 = 0.69314718055994531;
constexpr double kSqrtTwoPi = 2.5066282746310002;
constexpr double kThinnest = 1e-3, kThickest = 1e3;  // optical depths

// ln x by x = 2^k (1 + y) / (1 - y), |y| <= 0.2.
double logarithm(double x) {
  double k = 0.0;
  for (; x > 1.5; x *= 0.5) k += 1.0;
  for (; x < 0.75; x *= 2.0) k -= 1.0;
  const double y = (x - 1.0) / (x + 1.0), y2 = y * y;
  double sum = 0.0;
  for (int n = 23; n >= 1; n -= 2) sum = sum * y2 + 1.0 / n;
  return k * kLn2 + 2.0 * y * sum;
}

// exp(-x) of x >= 0: the series of a small part, squared as often as it was halved.
double decay(double x) {
  if (x > 700.0) return 0.0;
  int halvings = 0;
  for (; x > 0.125; x *= 0.5) ++halvings;
  double sum = 1.0;
  for (int n = 12; n >= 1; --n) sum = 1.0 - x / n * sum;
  for (; halvings > 0; --halvings) sum *= sum;
  return sum;
}

// Full width over sigma.
double widths(double depths) {
  const double half = kLn2 - logarithm(1.0 + decay(depths));
  return 2.0 * std::sqrt(2.0 * logarithm(depths / half));
}

}  // namespace

double VisibleWidth::depths(double section_mm2) const {
  return std::clamp(section_mm2 / (kSqrtTwoPi * sigma_mm_ * depth_mm_), kThinnest, kThickest);
}

double VisibleWidth::width_mm(double section_mm2) const { return sigma_mm_ * widths(depths(section_mm2)); }

double VisibleWidth::contrast(double section_mm2) const { return 1.0 - decay(depths(section_mm2)); }

double VisibleWidth::section_mm2(double width_mm) const {
  double low = kThinnest, high = kThickest;
  for (int n = 0; n < 80; ++n) {
    const double middle = std::sqrt(low * high);
    (widths(middle) * sigma_mm_ < width_mm ? low : high) = middle;
  }
  return low * kSqrtTwoPi * sigma_mm_ * depth_mm_;
}

double ink_depths(double contrast) { return -logarithm(1.0 - contrast); }

}  // namespace firn::control
