#include "plant/twins/servo.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace firn::plant {
namespace {

constexpr double kStep_s = 0.0005;
constexpr int kStepsPerKnot = 4;
constexpr double kLongestSettling_s = 3.0;
constexpr double kStands_mm = 2e-5, kStands_mm_s = 1e-3;

struct AxisState {
  double x = 0.0, v = 0.0;
};

}  // namespace

Following follow_plan(const Track& plan, const std::array<ServoAxis, 2>& axes, const TrackKnot& begin,
                      double position_error_mm) {
  const double end_s = double(plan.end_us() - plan.start_us()) * 1e-6;
  std::array<AxisState, 2> state{{{begin.x_mm, begin.vx_mm_s}, {begin.y_mm, begin.vy_mm_s}}};
  const auto wanted = [&](double t_s) {
    const auto us = plan.start_us() + std::llround(t_s * 1e6);
    return std::pair(plan.position(us), plan.velocity(us));
  };
  Following f;
  f.knots.push_back(begin);
  auto now = wanted(begin.t_s);
  double t = begin.t_s;
  for (int n = 1;; ++n) {
    const auto middle = wanted(t + 0.5 * kStep_s), next = wanted(t + kStep_s);
    for (std::size_t a = 0; a < 2; ++a) {
      const double w = 2.0 * std::numbers::pi * axes[a].hz, damp = 2.0 * axes[a].damping * w;
      const auto rate = [&](const AxisState& s, const auto& r) {
        return AxisState{s.v, w * w * (r.first[a] - s.x) + damp * (axes[a].feed_forward * r.second[a] - s.v)};
      };
      const auto moved = [](const AxisState& s, const AxisState& by, double h) {
        return AxisState{s.x + h * by.x, s.v + h * by.v};
      };
      const AxisState s = state[a], k1 = rate(s, now), k2 = rate(moved(s, k1, 0.5 * kStep_s), middle),
                      k3 = rate(moved(s, k2, 0.5 * kStep_s), middle), k4 = rate(moved(s, k3, kStep_s), next);
      state[a] = {s.x + kStep_s / 6.0 * (k1.x + 2.0 * k2.x + 2.0 * k3.x + k4.x),
                  s.v + kStep_s / 6.0 * (k1.v + 2.0 * k2.v + 2.0 * k3.v + k4.v)};
      if (std::abs(state[a].x - next.first[a]) > position_error_mm)
        f.too_far_s[a] = std::min(f.too_far_s[a], t + kStep_s);
    }
    now = next;
    t = begin.t_s + n * kStep_s;
    if (n % kStepsPerKnot != 0) continue;
    f.knots.push_back({t, state[0].x, state[1].x, state[0].v, state[1].v});
    const bool stands =
        std::max(std::abs(state[0].x - now.first[0]), std::abs(state[1].x - now.first[1])) < kStands_mm &&
        std::max(std::abs(state[0].v), std::abs(state[1].v)) < kStands_mm_s;
    if (t > end_s && (stands || t > end_s + kLongestSettling_s)) break;
  }
  // The last micrometre's hundredth is not seen: it ends on its target, at rest.
  f.settled_s = t;
  f.knots.back() = {t, now.first[0], now.first[1], 0.0, 0.0};
  return f;
}

}  // namespace firn::plant
