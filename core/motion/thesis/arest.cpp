#include "core/motion/thesis/arest.h"

#include <algorithm>
#include <cmath>

#include "core/motion/thesis/acon.h"
#include "core/motion/thesis/sections.h"

namespace firn::motion::thesis {
namespace {

Profile reversed(const Profile& profile) {
  Profile r = profile;
  std::reverse(r.points.begin(), r.points.end());
  std::reverse(r.yaw_rad.begin(), r.yaw_rad.end());
  std::reverse(r.dt_s.begin(), r.dt_s.end());
  std::reverse(r.speed_limit_mm_s.begin(), r.speed_limit_mm_s.end());
  for (auto& q : r.joints) std::reverse(q.begin(), q.end());
  const double length = profile.s_mm.back();
  for (std::size_t i = 0; i < r.size(); ++i) r.s_mm[i] = length - profile.s_mm[r.size() - 1 - i];
  return r;
}

/// A short path: both curves run on until they meet; the faster end of the two gives way.
void part(RestCurve& start, RestCurve& end, double length) {
  while (start.s_mm.back() + end.s_mm.back() >= length) {
    RestCurve& faster = start.speed_mm_s.back() >= end.speed_mm_s.back() ? start : end;
    faster.s_mm.pop_back();
    faster.speed_mm_s.pop_back();
  }
}

std::size_t interval_at(const Profile& profile, double s) {
  const auto it = std::upper_bound(profile.s_mm.begin(), profile.s_mm.end(), s);
  return std::clamp<std::size_t>(std::size_t(it - profile.s_mm.begin()), 1, profile.dt_s.size()) - 1;
}

void limit_joint(const std::vector<double>& q, const std::vector<double>& s, const RateLimits& limits,
                 const RestOptions& options, std::vector<double>& dt) {
  const Section first = sections(q).front();
  Ladder ladder{std::vector<double>(dt.size()), std::vector<double>(q.size(), kUnlimited)};
  for (std::size_t i = 0; i < dt.size(); ++i) ladder.step[i] = std::abs(q[i + 1] - q[i]);
  const double slope = ladder.step[0] / (s[1] - s[0]);
  const double begin = std::min(options.acceleration_mm_s2 * slope, limits.acceleration);
  acceleration_curve(ladder, {0, 0.0, begin}, +1, first.last, limits, dt);
}

}  // namespace

RestCurve rest_curve(const Profile& profile, const RateLimits& limits, const RestOptions& options) {
  const std::vector<double> radius = radii(profile.points);
  const double h = options.step_s, length = profile.s_mm.back();
  RestCurve curve{{0.0}, {0.0}};
  double s = 0.0, c = 0.0, a = std::min(options.acceleration_mm_s2, limits.acceleration);
  while (true) {
    const std::size_t k = interval_at(profile, s);
    const double radial = c * c / std::min(radius[k], radius[k + 1]);
    const double allowed = radial < limits.acceleration
                               ? std::sqrt(limits.acceleration * limits.acceleration - radial * radial)
                               : 0.0;
    const double next = std::min(a + limits.jerk * h, allowed);
    const double ds =
        c * h + (2.0 * std::min(a, allowed) + next) / 6.0 * h * h;  // acceleration linear in the step
    const double dc = 0.5 * (std::min(a, allowed) + next) * h;
    const std::size_t m = interval_at(profile, s + ds);
    const double envelope = (profile.s_mm[m + 1] - profile.s_mm[m]) / profile.dt_s[m];
    if (s + ds >= length || c + dc > envelope || ds <= 0.0) return curve;
    s += ds;
    c += dc;
    a = next;
    curve.s_mm.push_back(s);
    curve.speed_mm_s.push_back(c);
  }
}

Profile arest(const Profile& profile, const RateLimits& limits, const RestOptions& options) {
  const double length = profile.s_mm.back(), h = options.step_s;
  RestCurve start = rest_curve(profile, limits, options),
            end = rest_curve(reversed(profile), limits, options);
  part(start, end, length);
  const double from = start.s_mm.back(), to = length - end.s_mm.back();
  Profile out;
  const auto add = [&](double s, double dt) {
    if (!out.s_mm.empty()) {
      out.dt_s.push_back(dt);
      out.speed_limit_mm_s.push_back(
          profile.speed_limit_mm_s[interval_at(profile, 0.5 * (s + out.s_mm.back()))]);
    }
    out.s_mm.push_back(s);
    append_at(profile, s, out);
  };
  for (const double s : start.s_mm) add(s, h);
  // Between the curves the old durations, in proportion where a curve cut an interval; never faster than the
  // ends allow where the curves meet below the envelope.
  const double ends = std::max(0.5 * (start.speed_mm_s.back() + end.speed_mm_s.back()),
                               0.5 * std::sqrt(options.acceleration_mm_s2 * (to - from)));
  const double gap = 2.0 * std::max(ends, options.acceleration_mm_s2 * h) * h;
  const auto middle = [&](double s) {
    const double before = out.s_mm.back(), ds = s - before;
    const std::size_t k = interval_at(profile, 0.5 * (s + before));
    const double dt = ds * profile.dt_s[k] / (profile.s_mm[k + 1] - profile.s_mm[k]);
    add(s, to - from < gap ? std::max(dt, ds / ends) : dt);
  };
  const double tiny = 1e-9 * length;
  for (std::size_t i = 1; i + 1 < profile.size(); ++i)
    if (profile.s_mm[i] > from + tiny && profile.s_mm[i] < to - tiny) middle(profile.s_mm[i]);
  middle(to);
  for (std::size_t k = end.s_mm.size() - 1; k-- > 0;) add(length - end.s_mm[k], h);
  return out;
}

void arest_joints(Profile& profile, const MotionLimits& limits, const RestOptions& options) {
  for (int side = 0; side < 2; ++side) {
    for (std::size_t j = 0; j < profile.joints.size(); ++j)
      limit_joint(profile.joints[j], profile.s_mm, limits.joint[j], options, profile.dt_s);
    profile = reversed(profile);
  }
}

}  // namespace firn::motion::thesis
