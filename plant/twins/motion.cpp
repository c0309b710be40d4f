#include "plant/twins/motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace firn::plant {

Move Move::trapezoid(const Vec3& from, const Vec3& to, double speed_mm_s, double accel_mm_s2,
                     std::int64_t t0_us) {
  Move m;
  m.t0_us_ = t0_us;
  m.from_ = from;
  const Vec3 d{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  m.length_ = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (!(m.length_ > 0.0)) return m;
  for (int k = 0; k < 3; ++k) m.direction_[k] = d[k] / m.length_;
  const double a = accel_mm_s2, peak = std::min(speed_mm_s, std::sqrt(m.length_ * a));
  const double ramp_s = peak / a, ramp_mm = 0.5 * peak * ramp_s;
  const double cruise_mm = std::max(0.0, m.length_ - 2.0 * ramp_mm), cruise_s = cruise_mm / peak;
  m.phase_ = {Phase{0.0, 0.0, 0.0, a}, Phase{ramp_s, ramp_mm, peak, 0.0},
              Phase{ramp_s + cruise_s, ramp_mm + cruise_mm, peak, -a}};
  m.phases_ = 3;
  m.duration_s_ = 2.0 * ramp_s + cruise_s;
  return m;
}

Move Move::stop(const Vec3& from, const Vec3& direction, double speed_mm_s, double decel_mm_s2,
                std::int64_t t0_us) {
  Move m;
  m.t0_us_ = t0_us;
  m.from_ = from;
  if (!(speed_mm_s > 0.0)) return m;
  m.direction_ = direction;
  m.length_ = speed_mm_s * speed_mm_s / (2.0 * decel_mm_s2);
  m.duration_s_ = speed_mm_s / decel_mm_s2;
  m.phase_[0] = {0.0, 0.0, speed_mm_s, -decel_mm_s2};
  m.phases_ = 1;
  return m;
}

std::int64_t Move::end_us() const { return t0_us_ + std::int64_t(std::ceil(duration_s_ * 1e6)); }

const Move::Phase& Move::phase_at_t(double t_s) const {
  int n = 0;
  while (n + 1 < phases_ && t_s >= phase_[n + 1].t_s) ++n;
  return phase_[n];
}

const Move::Phase& Move::phase_at_s(double s_mm) const {
  int n = 0;
  while (n + 1 < phases_ && s_mm >= phase_[n + 1].s_mm) ++n;
  return phase_[n];
}

double Move::travelled_mm(std::int64_t t_us) const {
  const double t = double(t_us - t0_us_) * 1e-6;
  if (t <= 0.0) return 0.0;
  if (t >= duration_s_) return length_;
  const Phase& p = phase_at_t(t);
  const double dt = t - p.t_s;
  return std::clamp(p.s_mm + dt * (p.v_mm_s + 0.5 * p.a_mm_s2 * dt), 0.0, length_);
}

double Move::speed_mm_s(std::int64_t t_us) const {
  const double t = double(t_us - t0_us_) * 1e-6;
  if (t < 0.0 || t >= duration_s_) return 0.0;
  const Phase& p = phase_at_t(t);
  return std::max(0.0, p.v_mm_s + p.a_mm_s2 * (t - p.t_s));
}

Vec3 Move::position(std::int64_t t_us) const {
  const double s = travelled_mm(t_us);
  return {from_[0] + direction_[0] * s, from_[1] + direction_[1] * s, from_[2] + direction_[2] * s};
}

double Move::speed_at_s(double s_mm) const {
  const Phase& p = phase_at_s(s_mm);
  return std::sqrt(std::max(0.0, p.v_mm_s * p.v_mm_s + 2.0 * p.a_mm_s2 * (s_mm - p.s_mm)));
}

// From s = v t + a t^2 / 2, in the form that also holds for a = 0: t = 2 s / (v + sqrt(v^2 + 2 a s)).
double Move::time_of_s(double s_mm) const {
  if (s_mm <= 0.0) return 0.0;
  if (s_mm >= length_) return duration_s_;
  const Phase& p = phase_at_s(s_mm);
  const double ds = s_mm - p.s_mm, sum = p.v_mm_s + speed_at_s(s_mm);
  return sum > 0.0 ? p.t_s + 2.0 * ds / sum : p.t_s;
}

void Move::io(Archive& a) {
  a.all(t0_us_, from_, direction_, length_, duration_s_, phases_, phase_);
  if (phases_ < 0 || std::size_t(phases_) > phase_.size())
    throw std::runtime_error("world state: a move of " + std::to_string(phases_) + " phases");
}

}  // namespace firn::plant
