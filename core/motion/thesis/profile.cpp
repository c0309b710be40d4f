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

Point2 point_at(const Profile& profile, double s_mm) {
  const auto& s = profile.s_mm;
  if (s_mm <= s.front()) return profile.points.front();
  if (s_mm >= s.back()) return profile.points.back();
  const std::size_t i = std::size_t(std::upper_bound(s.begin(), s.end(), s_mm) - s.begin()) - 1;
  const double f = (s_mm - s[i]) / (s[i + 1] - s[i]);
  const Point2 &a = profile.points[i], &b = profile.points[i + 1];
  return {a.x_mm + f * (b.x_mm - a.x_mm), a.y_mm + f * (b.y_mm - a.y_mm)};
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
  if (n > 3) out.jerk[0] = out.jerk[1], out.jerk[n - 2] = out.jerk[n - 3];
  return out;
}

TotalRates total_rates(const Profile& profile) {
  const std::size_t n = profile.size();
  std::vector<double> x(n), y(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = profile.points[i].x_mm, y[i] = profile.points[i].y_mm;
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
