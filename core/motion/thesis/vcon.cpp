#include "core/motion/thesis/vcon.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"

namespace firn::motion::thesis {

Differences differences(const std::vector<double>& p) {
  const std::size_t n = p.size();
  Differences d;
  d.first.resize(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) d.first[i] = p[i + 1] - p[i];
  // D2 belongs to points 1..n-2, D3 to intervals 1..n-3; an interval takes the mean of its two points.
  const auto at_point = [&](std::size_t i) {
    i = std::clamp<std::size_t>(i, 1, n - 2);
    return d.first[i] - d.first[i - 1];
  };
  d.second.resize(n - 1);
  d.third.resize(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    d.second[i] = 0.5 * (at_point(i) + at_point(i + 1));
    const std::size_t k = std::clamp<std::size_t>(i, 1, n - 3);
    d.third[i] = at_point(k + 1) - at_point(k);
  }
  return d;
}

void impose_joint(const std::vector<double>& joint, const RateLimits& limits, std::vector<double>& dt) {
  const Differences d = differences(joint);
  for (std::size_t i = 0; i < dt.size(); ++i) {
    dt[i] = std::max(dt[i], std::abs(d.first[i]) / limits.rate);
    dt[i] = std::max(dt[i], std::sqrt(std::abs(d.second[i]) / limits.acceleration));
    dt[i] = std::max(dt[i], exact::cbrt(std::abs(d.third[i]) / limits.jerk));
  }
}

void impose_position(const std::vector<Point2>& points, const RateLimits& limits, std::vector<double>& dt) {
  std::vector<double> x, y;
  for (const Point2& p : points) {
    x.push_back(p.x_mm);
    y.push_back(p.y_mm);
  }
  const Differences dx = differences(x), dy = differences(y);
  for (std::size_t i = 0; i < dt.size(); ++i) {
    dt[i] = std::max(dt[i], std::sqrt(dx.first[i] * dx.first[i] + dy.first[i] * dy.first[i]) / limits.rate);
    const double second = std::sqrt(dx.second[i] * dx.second[i] + dy.second[i] * dy.second[i]);
    const double third = std::sqrt(dx.third[i] * dx.third[i] + dy.third[i] * dy.third[i]);
    dt[i] = std::max(dt[i], std::sqrt(second / limits.acceleration));
    dt[i] = std::max(dt[i], exact::cbrt(third / limits.jerk));
  }
}

void vcon(Profile& profile, const MotionLimits& limits) {
  profile.dt_s.assign(profile.size() - 1, 0.0);
  for (std::size_t i = 0; i < profile.dt_s.size(); ++i)
    profile.dt_s[i] = (profile.s_mm[i + 1] - profile.s_mm[i]) / profile.speed_limit_mm_s[i];
  impose_position(profile.points, limits.position, profile.dt_s);
  for (std::size_t j = 0; j < profile.joints.size(); ++j)
    impose_joint(profile.joints[j], limits.joint[j], profile.dt_s);
}

}  // namespace firn::motion::thesis
