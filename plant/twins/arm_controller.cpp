#include "plant/twins/arm_controller.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {
namespace {

constexpr double kFullAccel_s = 0.25;  // from rest to full rate

}  // namespace

std::vector<Joints> joint_move(const Joints& from, const Joints& to, double share) {
  double span_s = 2.0 * kRobotTick_s;
  for (std::size_t n = 0; n < 4; ++n) {
    const double way = std::abs(to[n] - from[n]), rate = kFullRate[n] * share;
    span_s = std::max({span_s, 1.875 * way / rate, std::sqrt(5.78 * way / (rate / kFullAccel_s))});
  }
  const int ticks = int(std::ceil(span_s / kRobotTick_s));
  std::vector<Joints> points(std::size_t(ticks) + 1);
  for (int k = 0; k <= ticks; ++k) {
    const double u = double(k) / ticks, s = u * u * u * (10.0 + u * (6.0 * u - 15.0));
    for (std::size_t n = 0; n < 4; ++n) points[std::size_t(k)][n] = from[n] + s * (to[n] - from[n]);
  }
  points.back() = to;
  return points;
}

bool in_range(const IceArmParams& params, const Joints& q) {
  for (std::size_t n = 0; n < 4; ++n) {
    const double value = n == 2 ? q[n] : q[n] / kRobotRad, slack = 1e-3;
    if (value < params.low[n] - slack || value > params.high[n] + slack) return false;
  }
  return true;
}

}  // namespace firn::plant
