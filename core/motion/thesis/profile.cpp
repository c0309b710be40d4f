#include "core/motion/thesis/profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::motion::thesis {

double Profile::duration_s() const {
  double sum = 0.0;
  for (const double dt : dt_s) sum += dt;
  return sum;
}

namespace {

struct Place {
  std::size_t interval;
  double share;  ///< of the interval, 0 to 1
};

Place place_at(const std::vector<double>& s, double s_mm) {
  if (s_mm <= s.front()) return {0, 0.0};
  if (s_mm >= s.back()) return {s.size() - 2, 1.0};
  const std::size_t i = std::size_t(std::upper_bound(s.begin(), s.end(), s_mm) - s.begin()) - 1;
  return {i, (s_mm - s[i]) / (s[i + 1] - s[i])};
}

double between(double a, double b, double share) { return share == 1.0 ? b : a + share * (b - a); }

Point2 point_at(const Profile& profile, Place place) {
  const Point2 &a = profile.points[place.interval], &b = profile.points[place.interval + 1];
  return {between(a.x_mm, b.x_mm, place.share), between(a.y_mm, b.y_mm, place.share)};
}

}  // namespace

Point2 point_at(const Profile& profile, double s_mm) {
  return point_at(profile, place_at(profile.s_mm, s_mm));
}

void append_at(const Profile& profile, double s_mm, Profile& out) {
  const Place place = place_at(profile.s_mm, s_mm);
  out.points.push_back(point_at(profile, place));
  if (profile.yaw_rad.empty()) return;
  const double* yaw = &profile.yaw_rad[place.interval];
  out.yaw_rad.push_back(between(yaw[0], yaw[1], place.share));
}

std::vector<double> radii(const std::vector<Point2>& p) {
  std::vector<double> r(p.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const double ax = p[i].x_mm - p[i - 1].x_mm, ay = p[i].y_mm - p[i - 1].y_mm;
    const double bx = p[i + 1].x_mm - p[i].x_mm, by = p[i + 1].y_mm - p[i].y_mm;
    const double cross = std::abs(ax * by - ay * bx), cx = ax + bx, cy = ay + by;
    const double sides = std::sqrt((ax * ax + ay * ay) * (bx * bx + by * by) * (cx * cx + cy * cy));
    if (cross > 1e-9 * sides) r[i] = sides / (2.0 * cross);
  }
  return r;
}

Rates rates(const std::vector<double>& values, const std::vector<double>& dt) {
  const std::size_t n = values.size();
  Rates out{std::vector<double>(n - 1), std::vector<double>(n), std::vector<double>(n - 1)};
  for (std::size_t i = 0; i + 1 < n; ++i) out.rate[i] = (values[i + 1] - values[i]) / dt[i];
  for (std::size_t i = 1; i + 1 < n; ++i)
    out.acceleration[i] = 2.0 * (out.rate[i] - out.rate[i - 1]) / (dt[i] + dt[i - 1]);
  out.acceleration[0] = out.acceleration[1];
  out.acceleration[n - 1] = out.acceleration[n - 2];
  for (std::size_t i = 0; i + 1 < n; ++i)
    out.jerk[i] = (out.acceleration[i + 1] - out.acceleration[i]) / dt[i];
  if (n > 3) {
    out.jerk[0] = out.jerk[1];
    out.jerk[n - 2] = out.jerk[n - 3];
  }
  return out;
}

TotalRates total_rates(const Profile& profile) {
  const std::size_t n = profile.size();
  std::vector<double> x(n), y(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = profile.points[i].x_mm;
    y[i] = profile.points[i].y_mm;
  }
  const Rates rx = rates(x, profile.dt_s), ry = rates(y, profile.dt_s);
  TotalRates total{std::vector<double>(n), std::vector<double>(n - 1)};
  for (std::size_t i = 0; i < n; ++i)
    total.acceleration[i] =
        std::sqrt(rx.acceleration[i] * rx.acceleration[i] + ry.acceleration[i] * ry.acceleration[i]);
  for (std::size_t i = 0; i + 1 < n; ++i)
    total.jerk[i] = std::sqrt(rx.jerk[i] * rx.jerk[i] + ry.jerk[i] * ry.jerk[i]);
  return total;
}

}  // namespace firn::motion::thesis
