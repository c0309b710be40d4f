#include "core/path/followed_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/path/polyline.h"
#include "core/statistics/median.h"

namespace firn {
namespace {

constexpr double kFine_s = 0.001;      // of the plan's points: a chord is 0.06 um off at 500 mm/s^2
constexpr double kLongestLag_s = 1.0;  // of a stage whose distance from the path still means something
constexpr double kEarly_s = 0.02;
constexpr double kSlowShare = 0.2;  // of the largest speed: below it the lag is not read
constexpr double kAcross_mm = 1.0;  // farther from a station is not at it
constexpr double kAlong = 0.7;      // cosine between the path and a station's direction

Point2 point_of(const PathKnot& k) { return {k.x_mm, k.y_mm}; }

/// A smooth curve through the samples, whose slopes are central differences.
class SampledCurve {
 public:
  explicit SampledCurve(std::span<const Point2> points) : points_(points), way_mm_{0.0} {
    for (std::size_t k = 0; k + 1 < points_.size(); ++k) way_mm_.push_back(way_mm_.back() + length(k, 1.0));
  }

  double length_mm() const { return way_mm_.back(); }
  Point2 at_way(double s_mm) const {
    const auto after = std::ranges::upper_bound(way_mm_, s_mm);
    const std::size_t k =
        std::min(std::size_t(std::max<std::ptrdiff_t>(1, after - way_mm_.begin())), points_.size() - 1) - 1;
    double low = 0.0, high = 1.0;
    for (int n = 0; n < 40; ++n) {
      const double middle = 0.5 * (low + high);
      (way_mm_[k] + length(k, middle) < s_mm ? low : high) = middle;
    }
    return place(k, high);
  }

 private:
  Point2 slope(std::size_t k) const {
    const std::size_t before = k > 0 ? k - 1 : 0, after = std::min(k + 1, points_.size() - 1);
    const double by = double(after - before);
    return {(points_[after].x_mm - points_[before].x_mm) / by,
            (points_[after].y_mm - points_[before].y_mm) / by};
  }
  Point2 place(std::size_t k, double u) const {
    const Point2 &a = points_[k], &b = points_[k + 1], m = slope(k), n = slope(k + 1);
    const auto cubic = [u](double p, double dp, double q, double dq) {
      return p + u * (dp + u * (3.0 * (q - p) - 2.0 * dp - dq + u * (2.0 * (p - q) + dp + dq)));
    };
    return {cubic(a.x_mm, m.x_mm, b.x_mm, n.x_mm), cubic(a.y_mm, m.y_mm, b.y_mm, n.y_mm)};
  }
  double speed(std::size_t k, double u) const {
    const Point2 &a = points_[k], &b = points_[k + 1], m = slope(k), n = slope(k + 1);
    const auto rate = [u](double p, double dp, double q, double dq) {
      return dp + u * (2.0 * (3.0 * (q - p) - 2.0 * dp - dq) + 3.0 * u * (2.0 * (p - q) + dp + dq));
    };
    const double x = rate(a.x_mm, m.x_mm, b.x_mm, n.x_mm), y = rate(a.y_mm, m.y_mm, b.y_mm, n.y_mm);
    return std::sqrt(x * x + y * y);
  }
  double length(std::size_t k, double to) const {
    constexpr double kNode = 0.7745966692414834;  // sqrt(3/5), Gauss's rule with 3 points
    const double half = 0.5 * to;
    return half *
           (5.0 * speed(k, half * (1.0 - kNode)) + 8.0 * speed(k, half) +
            5.0 * speed(k, half * (1.0 + kNode))) /
           9.0;
  }

  std::span<const Point2> points_;
  std::vector<double> way_mm_;
};

}  // namespace

TimedPath::TimedPath(std::vector<PathKnot> knots) : knots_(std::move(knots)) {
  if (knots_.empty()) return;
  const auto steps = std::size_t(std::ceil(duration_s() / kFine_s));
  for (std::size_t n = 0; n <= steps; ++n) {
    fine_.push_back(point_of(at(double(n) * kFine_s)));
    const double x = n == 0 ? 0.0 : fine_[n].x_mm - fine_[n - 1].x_mm,
                 y = n == 0 ? 0.0 : fine_[n].y_mm - fine_[n - 1].y_mm;
    way_mm_.push_back((n == 0 ? 0.0 : way_mm_.back()) + std::sqrt(x * x + y * y));
  }
}

PathKnot TimedPath::at(double t_s) const {
  PathKnot end = t_s <= 0.0 ? knots_.front() : knots_.back();
  if (!(t_s > 0.0 && t_s < duration_s())) {
    end.vx_mm_s = end.vy_mm_s = 0.0;
    return end;
  }
  const auto after = std::ranges::upper_bound(knots_, t_s, {}, &PathKnot::t_s);
  const PathKnot &a = *(after - 1), &b = *after;
  const double h = b.t_s - a.t_s, t = t_s - a.t_s;
  PathKnot k{t_s};
  const auto axis = [&](double p0, double v0, double p1, double v1, double& p, double& v) {
    const double c2 = (3.0 * (p1 - p0) / h - 2.0 * v0 - v1) / h;
    const double c3 = (v0 + v1 - 2.0 * (p1 - p0) / h) / (h * h);
    p = p0 + t * (v0 + t * (c2 + t * c3));
    v = v0 + t * (2.0 * c2 + 3.0 * t * c3);
  };
  axis(a.x_mm, a.vx_mm_s, b.x_mm, b.vx_mm_s, k.x_mm, k.vx_mm_s);
  axis(a.y_mm, a.vy_mm_s, b.y_mm, b.vy_mm_s, k.y_mm, k.vy_mm_s);
  return k;
}

double TimedPath::distance_mm(const Point2& from, double begin_s, double end_s) const {
  const auto last = std::ptrdiff_t(fine_.size()) - 1;
  const auto begin = std::clamp<std::ptrdiff_t>(std::ptrdiff_t(begin_s / kFine_s), 0, last);
  const auto end = std::clamp<std::ptrdiff_t>(std::ptrdiff_t(end_s / kFine_s) + 1, begin, last);
  double least = squared_distance(from, fine_[std::size_t(begin)], fine_[std::size_t(begin)]);
  for (auto n = begin; n < end; ++n)
    least = std::min(least, squared_distance(from, fine_[std::size_t(n)], fine_[std::size_t(n) + 1]));
  return std::sqrt(least);
}

PathKnot TimedPath::at_way(double s_mm) const {
  const auto after = std::ranges::upper_bound(way_mm_, s_mm);
  if (after == way_mm_.begin()) return at(0.0);
  if (after == way_mm_.end()) return at(duration_s());
  const auto n = std::size_t(after - way_mm_.begin());
  return at((double(n - 1) + (s_mm - way_mm_[n - 1]) / (way_mm_[n] - way_mm_[n - 1])) * kFine_s);
}

std::vector<double> contour_errors_mm(const TimedPath& plan, double period_s,
                                      std::span<const Point2> followed) {
  std::vector<double> out;
  for (std::size_t k = 0; k < followed.size(); ++k) {
    const double t = double(k) * period_s;
    out.push_back(plan.distance_mm(followed[k], t - kLongestLag_s, t + kEarly_s));
  }
  return out;
}

PathErrors path_errors(const TimedPath& plan, double period_s, std::span<const Point2> followed,
                       std::span<const double> switch_mm) {
  PathErrors e;
  e.samples = followed.size();
  if (followed.empty()) return e;
  const std::vector<double> contour = contour_errors_mm(plan, period_s, followed);
  double square = 0.0, fastest = 0.0;
  for (std::size_t k = 0; k < followed.size(); ++k) {
    const PathKnot p = plan.at(double(k) * period_s);
    fastest = std::max(fastest, p.vx_mm_s * p.vx_mm_s + p.vy_mm_s * p.vy_mm_s);
    square += contour[k] * contour[k];
  }
  e.contour_rms_mm = std::sqrt(square / double(followed.size()));
  const auto worst = std::size_t(std::ranges::max_element(contour) - contour.begin());
  e.contour_max_mm = contour[worst];
  e.worst = followed[worst];
  e.worst_s = double(worst) * period_s;
  std::vector<double> lags;
  e.following_max_mm = 0.0;
  for (std::size_t k = 0; k < followed.size(); ++k) {
    const PathKnot p = plan.at(double(k) * period_s);
    const double x = p.x_mm - followed[k].x_mm, y = p.y_mm - followed[k].y_mm,
                 speed2 = p.vx_mm_s * p.vx_mm_s + p.vy_mm_s * p.vy_mm_s;
    e.following_max_mm = std::max(e.following_max_mm, std::sqrt(x * x + y * y));
    if (!(speed2 > kSlowShare * kSlowShare * fastest)) continue;
    const double lag = (x * p.vx_mm_s + y * p.vy_mm_s) / speed2;
    e.lag_max_s = std::isnan(e.lag_max_s) ? lag : std::max(e.lag_max_s, lag);
    lags.push_back(lag);
  }
  const double usual_s = lags.empty() ? 0.0 : statistics::upper_median(lags);
  for (std::size_t k = 0; k < followed.size(); ++k) {
    const PathKnot p = plan.at(double(k) * period_s - usual_s);
    const double x = p.x_mm - followed[k].x_mm, y = p.y_mm - followed[k].y_mm,
                 distance = std::sqrt(x * x + y * y);
    if (distance <= e.stall_max_mm) continue;
    e.stall_max_mm = distance;
    e.stall_s = double(k) * period_s;
  }
  if (followed.size() < 2) return e;
  const SampledCurve curve(followed);
  for (std::size_t n = 0; n < switch_mm.size(); ++n) {
    const double s = switch_mm[n];
    if (s > curve.length_mm() || s > plan.length_mm()) continue;
    const Point2 there = curve.at_way(s);
    const PathKnot wanted = plan.at_way(s);
    const double speed = std::sqrt(wanted.vx_mm_s * wanted.vx_mm_s + wanted.vy_mm_s * wanted.vy_mm_s);
    const double x = there.x_mm - wanted.x_mm, y = there.y_mm - wanted.y_mm;
    const double along =
        speed > 0.0 ? std::abs(x * wanted.vx_mm_s + y * wanted.vy_mm_s) / speed : std::sqrt(x * x + y * y);
    if (along <= e.switch_max_mm) continue;
    e.switch_max_mm = along;
    e.worst_switch = int(n);
  }
  return e;
}

double station_offset_rms_mm(std::span<const Point2> followed, std::span<const LineStation> stations) {
  double square = 0.0;
  int passed = 0;
  for (const LineStation& s : stations) {
    double nearest = kAcross_mm;
    for (std::size_t k = 0; k + 1 < followed.size(); ++k) {
      const Point2 &a = followed[k], &b = followed[k + 1];
      const double from = (a.x_mm - s.at.x_mm) * s.direction.x_mm + (a.y_mm - s.at.y_mm) * s.direction.y_mm,
                   to = (b.x_mm - s.at.x_mm) * s.direction.x_mm + (b.y_mm - s.at.y_mm) * s.direction.y_mm;
      if (!(from <= 0.0 && to > 0.0)) continue;
      const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
      if (!(to - from > kAlong * std::sqrt(dx * dx + dy * dy))) continue;
      const double share = -from / (to - from);
      const double x = a.x_mm + share * dx - s.at.x_mm, y = a.y_mm + share * dy - s.at.y_mm;
      nearest = std::min(nearest, std::abs(y * s.direction.x_mm - x * s.direction.y_mm));
    }
    if (!(nearest < kAcross_mm)) continue;
    square += nearest * nearest;
    ++passed;
  }
  return passed > 0 ? std::sqrt(square / passed) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace firn
