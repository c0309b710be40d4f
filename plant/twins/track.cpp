#include "plant/twins/track.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {

Track::Track(std::vector<TrackKnot> knots, std::int64_t start_us, int parts_per_knot)
    : knots_(std::move(knots)), start_us_(start_us), parts_(parts_per_knot) {
  measure();
}

std::int64_t Track::end_us() const {
  return start_us_ + (knots_.empty() ? 0 : std::int64_t(std::ceil(knots_.back().t_s * 1e6)));
}

Track::State Track::within(std::size_t k, double t_s) const {
  const TrackKnot &a = knots_[k], &b = knots_[k + 1];
  const double h = b.t_s - a.t_s, t = t_s - a.t_s;
  const auto axis = [&](double p0, double v0, double p1, double v1, double& p, double& v) {
    const double c2 = (3.0 * (p1 - p0) / h - 2.0 * v0 - v1) / h;
    const double c3 = (v0 + v1 - 2.0 * (p1 - p0) / h) / (h * h);
    p = p0 + t * (v0 + t * (c2 + t * c3));
    v = v0 + t * (2.0 * c2 + 3.0 * t * c3);
  };
  State s;
  axis(a.x_mm, a.vx_mm_s, b.x_mm, b.vx_mm_s, s.p[0], s.v[0]);
  axis(a.y_mm, a.vy_mm_s, b.y_mm, b.vy_mm_s, s.p[1], s.v[1]);
  return s;
}

Track::State Track::at(double t_s) const {
  if (t_s <= 0.0) return {{knots_.front().x_mm, knots_.front().y_mm}, {}};
  if (t_s >= knots_.back().t_s) return {{knots_.back().x_mm, knots_.back().y_mm}, {}};
  const auto after = std::ranges::upper_bound(knots_, t_s, {}, &TrackKnot::t_s);
  return within(std::size_t(after - knots_.begin()) - 1, t_s);
}

double Track::way_over(std::size_t k, double from_s, double to_s) const {
  constexpr double kNode = 0.7745966692414834;  // sqrt(3/5)
  const double middle = 0.5 * (from_s + to_s), half = 0.5 * (to_s - from_s);
  const auto speed = [&](double t) {
    const State s = within(k, t);
    return std::sqrt(s.v[0] * s.v[0] + s.v[1] * s.v[1]);
  };
  return half *
         (5.0 * speed(middle - half * kNode) + 8.0 * speed(middle) + 5.0 * speed(middle + half * kNode)) /
         9.0;
}

double Track::part_begin_s(std::size_t part) const {
  const std::size_t parts = std::size_t(parts_), k = part / parts;
  if (k + 1 >= knots_.size()) return knots_.back().t_s;
  return knots_[k].t_s + (knots_[k + 1].t_s - knots_[k].t_s) * double(part % parts) / double(parts);
}

void Track::measure() {
  way_mm_.assign(1, 0.0);
  const std::size_t parts = std::size_t(parts_);
  for (std::size_t part = 0; part < parts * (knots_.size() - 1); ++part)
    way_mm_.push_back(way_mm_.back() + way_over(part / parts, part_begin_s(part), part_begin_s(part + 1)));
}

double Track::travelled_mm(std::int64_t t_us) const {
  const double t = seconds(t_us);
  if (t <= 0.0) return 0.0;
  if (t >= knots_.back().t_s) return length_mm();
  const auto after = std::ranges::upper_bound(knots_, t, {}, &TrackKnot::t_s);
  const std::size_t k = std::size_t(after - knots_.begin()) - 1;
  std::size_t part = k * std::size_t(parts_);
  while (part + 1 < (k + 1) * std::size_t(parts_) && part_begin_s(part + 1) <= t) ++part;
  return way_mm_[part] + way_over(k, part_begin_s(part), t);
}

double Track::time_of_s(double s_mm) const {
  if (s_mm <= 0.0) return 0.0;
  if (s_mm >= length_mm()) return knots_.back().t_s;
  const auto after = std::ranges::upper_bound(way_mm_, s_mm);
  const std::size_t part = std::size_t(after - way_mm_.begin()) - 1;
  double low = part_begin_s(part), high = part_begin_s(part + 1);
  for (int n = 0; n < 48 && high - low > 1e-9; ++n) {
    const double middle = 0.5 * (low + high);
    const bool before =
        way_mm_[part] + way_over(part / std::size_t(parts_), part_begin_s(part), middle) < s_mm;
    (before ? low : high) = middle;
  }
  return high;
}

void Track::io(Archive& a) {
  a.all(knots_, start_us_, parts_);
  if (a.loading() && knots_.size() > 1) measure();
}

}  // namespace firn::plant
