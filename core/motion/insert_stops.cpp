#include "core/motion/insert_stops.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr double kCornerCosine = 0.9961946980917455;  // 5 degrees
constexpr double kFilled = 0.9,
                 kMaxFilled = 0.97;  // of a piece's capacity: planned, and after moving to a corner
constexpr double kNearShare = 0.02;  // of a part: so near, a point of the path serves

/// Length of the polygon up to each point; a closed one ends with its first point.
std::vector<double> lengths_of(const std::vector<Point2>& p, bool closed) {
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < p.size() + (closed ? 1 : 0); ++i)
    s.push_back(s.back() + distance(p[i - 1], p[i % p.size()]));
  return s;
}

bool corner_at(const std::vector<Point2>& p, std::size_t i) {
  if (i == 0 || i + 1 >= p.size()) return false;
  const double ux = p[i].x_mm - p[i - 1].x_mm, uy = p[i].y_mm - p[i - 1].y_mm;
  const double vx = p[i + 1].x_mm - p[i].x_mm, vy = p[i + 1].y_mm - p[i].y_mm;
  return ux * vx + uy * vy <= kCornerCosine * distance(p[i - 1], p[i]) * distance(p[i], p[i + 1]);
}

/// Puts a new point on the segment before point `i`.
void insert_point(std::vector<Point2>& p, std::vector<double>& speed_limit, std::vector<double>& yaw,
                  std::size_t i, double share, std::vector<std::size_t>& stops) {
  const Point2 a = p[i - 1], b = p[i % p.size()];
  if (!speed_limit.empty())
    speed_limit.insert(speed_limit.begin() + std::ptrdiff_t(i),
                       std::min(speed_limit[i - 1], speed_limit[i % p.size()]));
  if (!yaw.empty())
    yaw.insert(yaw.begin() + std::ptrdiff_t(i), yaw[i - 1] + share * (yaw[i % p.size()] - yaw[i - 1]));
  p.insert(p.begin() + std::ptrdiff_t(i),
           {a.x_mm + share * (b.x_mm - a.x_mm), a.y_mm + share * (b.y_mm - a.y_mm)});
  for (std::size_t& stop : stops)
    if (stop >= i) ++stop;
}

}  // namespace

std::vector<InsertedStop> insert_stops(std::vector<Point2>& points, bool closed, PathSpeedLimit& speed_limit,
                                       std::vector<double>& yaw_rad, const UndividedSpan& span,
                                       std::vector<std::size_t>& stops) {
  const std::span<const double> speed = span.speed_mm_s;
  const double from = double(span.from), to = double(span.to), holds = double(span.fits) - from;
  const double parts = std::max(2.0, std::ceil((to - from) / (kFilled * holds))), part = (to - from) / parts;
  const double slack =
      std::max(0.0, 0.5 * (kMaxFilled * holds - part));  // either neighbour may move by so much
  std::vector<double> driven{0.0};                       // length at each instant
  for (std::size_t n = 1; n < speed.size(); ++n)
    driven.push_back(driven.back() + 0.5 * span.step_s * (speed[n - 1] + speed[n]));
  const double scale = lengths_of(points, closed).back() / driven.back();  // corners may have been rolled
  const auto along = [&](double instant) {
    return scale * driven[std::min(std::size_t(std::max(0.0, instant)), driven.size() - 1)];
  };
  const auto speed_at = [&](double length) {
    const auto n = std::lower_bound(driven.begin(), driven.end(), length / scale) - driven.begin();
    return speed[std::min(std::size_t(n), driven.size() - 1)];
  };
  std::vector<InsertedStop> added;
  for (double k = 1.0; k < parts; ++k) {
    const std::vector<double> s = lengths_of(points, closed);
    const std::vector<Point2>& p = points;
    const double goal = from + k * part, middle = along(goal), low = along(goal - slack),
                 high = along(goal + slack);
    std::size_t corner = 0, near = 0;
    for (std::size_t i = 1; i + 1 < s.size(); ++i) {
      if (s[i] < low || s[i] > high) continue;
      const bool nearer = near == 0 || std::abs(s[i] - middle) < std::abs(s[near] - middle);
      if (nearer) near = i;
      if (corner_at(p, i) && (corner == 0 || speed_at(s[i]) < speed_at(s[corner]))) corner = i;
    }
    std::size_t chosen = corner;
    if (chosen == 0 && near != 0 &&
        std::abs(s[near] - middle) <= kNearShare * (along(goal + part) - along(goal - part)))
      chosen = near;
    if (chosen == 0) {
      chosen = std::size_t(std::upper_bound(s.begin(), s.end(), middle) - s.begin());
      if (chosen == 0 || chosen >= s.size()) continue;
      insert_point(points, speed_limit.point_mm_s, yaw_rad, chosen,
                   (middle - s[chosen - 1]) / (s[chosen] - s[chosen - 1]), stops);
    }
    const auto place = std::lower_bound(stops.begin(), stops.end(), chosen);
    if (place != stops.end() && *place == chosen) continue;
    stops.insert(place, chosen);
    added.push_back({lengths_of(points, closed)[chosen], points[chosen], corner != 0});
  }
  return added;
}

}  // namespace firn::motion
