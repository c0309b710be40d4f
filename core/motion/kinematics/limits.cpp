#include "core/motion/kinematics/limits.h"

#include <cmath>
#include <numbers>
#include <string>

#include "core/motion/kinematics/require.h"

namespace firn::motion {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void require_limits(const RateLimits& limits, const std::string& what, bool finite, int axis = -1) {
  const auto limit = [&](double value, const char* of) {
    require(value > 0.0 && (!finite || std::isfinite(value)), Reason::kLimitNotPositive, what + of, value,
            0.0, axis);
  };
  limit(limits.rate, " rate");
  limit(limits.acceleration, " acceleration");
  limit(limits.jerk, " jerk");
}

bool limited(const RateLimits& l) {
  return l.rate < kUnlimited || l.acceleration < kUnlimited || l.jerk < kUnlimited;
}

}  // namespace

RateLimits rate_limits(std::string_view where, const AxisRates& rates, double unit) {
  check_options(where, kAxisRates, rates);
  const auto limit = [&](double value) { return value > 0.0 ? value * unit : kUnlimited; };
  return {limit(rates.rate), limit(rates.acceleration), limit(rates.jerk)};
}

MotionLimits cobra600_limits() {
  MotionLimits limits;
  limits.position = kCobra600Position;
  limits.joint[0] = rate_limits("joint", kCobra600Joint1, kDegree);
  limits.joint[1] = rate_limits("joint", kCobra600Joint2, kDegree);
  return limits;
}

int limited_joints(const MotionLimits& limits, int joints) {
  int last = 0;
  for (int j = 0; j < joints; ++j)
    if (limited(limits.joint[std::size_t(j)])) last = j + 1;
  return last;
}

void check_limits(const MotionLimits& limits, int joints) {
  require_limits(limits.position, "total position", true);
  require_limits(limits.orientation, "orientation", false);
  for (int j = 0; j < joints; ++j) require_limits(limits.joint[std::size_t(j)], "joint", false, j);
}

void check_speed_limit(const PathSpeedLimit& speed_limit, std::size_t points) {
  Fault fault{Reason::kSpeedLimitNotPositive};
  if (!(speed_limit.path_mm_s > 0.0)) {
    fault.value = speed_limit.path_mm_s;
    throw MotionError(fault);
  }
  if (speed_limit.point_mm_s.empty()) return;
  if (speed_limit.point_mm_s.size() != points) {
    fault.reason = Reason::kSpeedLimitSize;
    fault.value = double(speed_limit.point_mm_s.size());
    fault.bound = double(points);
    throw MotionError(fault);
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (speed_limit.point_mm_s[i] > 0.0) continue;
    fault.index = i;
    fault.value = speed_limit.point_mm_s[i];
    throw MotionError(fault);
  }
}

}  // namespace firn::motion
