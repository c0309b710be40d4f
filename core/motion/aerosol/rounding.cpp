#include "core/motion/aerosol/rounding.h"

#include <cmath>

#include "core/exact/exact_math.h"

namespace firn::motion {

namespace {
constexpr double kLargestStep_rad = 0.05;
}

Rounding round_corner(const Point2& from, const Point2& to, double v, double alpha) {
  Rounding r;
  const double cross = from.x_mm * to.y_mm - from.y_mm * to.x_mm,
               dot = from.x_mm * to.x_mm + from.y_mm * to.y_mm;
  const double phi = exact::atan2(cross, dot);  // signed turn
  if (phi == 0.0) return r;
  const int n = 2 * int(std::ceil(std::abs(phi) / (2.0 * kLargestStep_rad)));
  const double psi = phi / n, heading = exact::atan2(from.y_mm, from.x_mm);
  const double step_s = 2.0 * v * exact::sin(std::abs(psi) / 2.0) / alpha;
  r.tangent_mm = v * v / alpha * exact::cos(psi / 2.0) * exact::tan(std::abs(phi) / 2.0);
  r.duration_s = n * step_s;
  Point2 p{-r.tangent_mm * from.x_mm, -r.tangent_mm * from.y_mm};
  for (int k = 0; k < n; ++k) {
    if (k == n / 2) r.deviation_mm = distance({}, p);
    const double a0 = heading + k * psi, a1 = heading + (k + 1) * psi;
    const exact::SinCos d0 = exact::sincos(a0), d1 = exact::sincos(a1);
    const Point2 v0{v * d0.cos, v * d0.sin}, v1{v * d1.cos, v * d1.sin};
    r.pieces.push_back({PieceKind::kRound,
                        0,
                        k * step_s,
                        step_s,
                        p,
                        v0,
                        {(v1.x_mm - v0.x_mm) / step_s, (v1.y_mm - v0.y_mm) / step_s}});
    p.x_mm += 0.5 * (v0.x_mm + v1.x_mm) * step_s;
    p.y_mm += 0.5 * (v0.y_mm + v1.y_mm) * step_s;
  }
  return r;
}

}  // namespace firn::motion
