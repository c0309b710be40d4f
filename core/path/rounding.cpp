#include "core/path/rounding.h"

#include <cmath>

namespace firn {
namespace {

constexpr int kMinDecimals = 2, kMaxDecimals = 8;
constexpr double kWhole = 1e-4;  ///< of a unit: what the nearest double to a decimal number is off by at most

bool whole(double value, double unit) {
  const double scaled = value * unit;
  return std::abs(scaled - std::nearbyint(scaled)) < kWhole;
}

}  // namespace

double rounding_mm(std::span<const Point2> points) {
  int decimals = 0;
  double unit = 1.0;
  for (const Point2& p : points)
    while (!whole(p.x_mm, unit) || !whole(p.y_mm, unit)) {
      if (++decimals > kMaxDecimals) return 0.0;
      unit *= 10.0;
    }
  return decimals < kMinDecimals ? 0.0 : 0.5 / unit;
}

}  // namespace firn
