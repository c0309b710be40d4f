#include "core/motion/aerosol/lspb.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr double kForgivenTime =
    1e-9;  // of the longest time in a move: rounding, not a broken order of times

// (5), (6) for one candidate, and the order (18).
std::optional<AxisProfile> with_blends(const AxisEnds& e, double t0, double t1, double vc, double a0,
                                       double a1) {
  if (!std::isfinite(vc)) return std::nullopt;
  double tb0 = (vc - e.v0_mm_s) / a0 + t0;  // (5)
  double tb1 = (vc - e.v1_mm_s) / a1 + t1;  // (6)
  const double slack = kForgivenTime * (t1 - t0 + (std::abs(e.v0_mm_s) + std::abs(e.v1_mm_s)) / std::abs(a0));
  if (tb0 < t0 - slack || tb1 < tb0 - slack || tb1 > t1 + slack) return std::nullopt;
  tb0 = std::clamp(tb0, t0, t1);
  tb1 = std::clamp(tb1, tb0, t1);
  return AxisProfile{e, t0, tb0, tb1, t1, vc, a0, a1};
}

// A root that is negative by rounding only is a double root.
double lspb_root(double gamma, double scale) {
  return gamma < 0 && gamma > -1e-13 * scale ? 0.0 : std::sqrt(gamma);
}

}  // namespace

LspbCandidates lspb_candidates(const AxisEnds& e, double t0, double t1, double alpha) {
  const double v0 = e.v0_mm_s, v1 = e.v1_mm_s, dq = e.q1_mm - e.q0_mm, dt = t1 - t0;
  const double squares = v0 * v0 + v1 * v1, half_difference = 0.5 * (v0 * v0 - v1 * v1);
  LspbCandidates found;
  const double s1 = (v0 + v1) / alpha + dt;
  const double gamma_1 = s1 * s1 + 2.0 / alpha * (-squares / alpha - 2.0 * dq);   // (12)
  const double root_1 = lspb_root(gamma_1, s1 * s1 + squares / (alpha * alpha));  // NaN when imaginary (17)
  found[0] = with_blends(e, t0, t1, 0.5 * alpha * (s1 + root_1), alpha, -alpha);  // (11)
  found[1] = with_blends(e, t0, t1, 0.5 * alpha * (s1 - root_1), alpha, -alpha);
  const double s2 = -(v0 + v1) / alpha + dt;
  const double gamma_2 = s2 * s2 - 2.0 / alpha * (squares / alpha - 2.0 * dq);  // (14)
  const double root_2 = lspb_root(gamma_2, s2 * s2 + squares / (alpha * alpha));
  found[2] = with_blends(e, t0, t1, -0.5 * alpha * (s2 + root_2), -alpha, alpha);  // (13)
  found[3] = with_blends(e, t0, t1, -0.5 * alpha * (s2 - root_2), -alpha, alpha);
  // (15), (16) with t1 - t0: as printed, t1 + t0, they hold at t0 = 0 only.
  found[4] = with_blends(e, t0, t1, (alpha * dq + half_difference) / (v0 - v1 + alpha * dt), alpha, alpha);
  found[5] = with_blends(e, t0, t1, (-alpha * dq + half_difference) / (v0 - v1 - alpha * dt), -alpha, -alpha);
  return found;
}

std::optional<AxisProfile> lspb(const AxisEnds& ends, double t0, double t1, double alpha) {
  std::optional<AxisProfile> best;
  for (const std::optional<AxisProfile>& c : lspb_candidates(ends, t0, t1, alpha))
    if (c && (!best || std::abs(c->vc_mm_s) < std::abs(best->vc_mm_s))) best = c;
  return best;
}

}  // namespace firn::motion
