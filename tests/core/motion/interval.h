// Interval arithmetic with outward rounding, and Taylor coefficients of intervals: the checker's own
// mathematics.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace firn::motion {

struct Interval {
  double low = 0.0, high = 0.0;
  Interval() = default;
  Interval(double value) : low(value), high(value) {}
  Interval(double a, double b) : low(a), high(b) {}
  double largest() const { return std::max(std::abs(low), std::abs(high)); }
};

/// One or two units in the last place outwards: |x| 2^-52 is at least one. The smallest double serves near 0.
inline Interval outward(double low, double high) {
  using Limits = std::numeric_limits<double>;
  const auto unit = [](double x) { return std::abs(x) * Limits::epsilon() + Limits::denorm_min(); };
  return {low == Limits::infinity() ? Limits::max() : low - unit(low),
          high == -Limits::infinity() ? -Limits::max() : high + unit(high)};
}
inline Interval operator+(Interval a, Interval b) { return outward(a.low + b.low, a.high + b.high); }
inline Interval operator-(Interval a, Interval b) { return outward(a.low - b.high, a.high - b.low); }
inline Interval operator*(Interval a, Interval b) {
  const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
  return outward(std::min({p, q, r, s}), std::max({p, q, r, s}));
}
inline Interval square(Interval a) {
  const double p = a.low * a.low, q = a.high * a.high;
  return outward(a.low <= 0.0 && a.high >= 0.0 ? 0.0 : std::min(p, q), std::max(p, q));
}
/// @pre b does not contain 0
inline Interval operator/(Interval a, Interval b) { return a * outward(1.0 / b.high, 1.0 / b.low); }
inline Interval root(Interval a) { return outward(std::sqrt(std::max(0.0, a.low)), std::sqrt(a.high)); }
inline Interval meet(Interval a, Interval b) { return {std::max(a.low, b.low), std::min(a.high, b.high)}; }

/// f, f', f'' / 2, f''' / 6, ... of a function over an interval of its parameter.
inline constexpr std::size_t kTaylor = 5;
struct Taylor {
  std::array<Interval, kTaylor> c{};
};
inline Taylor operator+(const Taylor& a, const Taylor& b) {
  Taylor r;
  for (std::size_t n = 0; n < kTaylor; ++n) r.c[n] = a.c[n] + b.c[n];
  return r;
}
inline Taylor operator-(const Taylor& a, const Taylor& b) {
  Taylor r;
  for (std::size_t n = 0; n < kTaylor; ++n) r.c[n] = a.c[n] - b.c[n];
  return r;
}
inline Taylor operator*(const Taylor& a, const Taylor& b) {
  Taylor r;
  for (std::size_t n = 0; n < kTaylor; ++n)
    for (std::size_t k = 0; k <= n; ++k) r.c[n] = r.c[n] + a.c[k] * b.c[n - k];
  return r;
}
inline Taylor operator*(Interval a, const Taylor& b) {
  Taylor r;
  for (std::size_t n = 0; n < kTaylor; ++n) r.c[n] = a * b.c[n];
  return r;
}
inline Taylor operator/(const Taylor& a, const Taylor& b) {
  Taylor r;
  for (std::size_t n = 0; n < kTaylor; ++n) {
    Interval sum = a.c[n];
    for (std::size_t k = 0; k < n; ++k) sum = sum - r.c[k] * b.c[n - k];
    r.c[n] = sum / b.c[0];
  }
  return r;
}
inline Taylor root(const Taylor& a) {
  Taylor r;
  r.c[0] = root(a.c[0]);
  for (std::size_t n = 1; n < kTaylor; ++n) {
    Interval sum = a.c[n];
    for (std::size_t k = 1; k < n; ++k) sum = sum - r.c[k] * r.c[n - k];
    r.c[n] = sum / (Interval(2.0) * r.c[0]);
  }
  return r;
}
/// f' as a series of its own: the last coefficient is lost, and unknown.
inline Taylor derivative(const Taylor& a) {
  Taylor r;
  for (std::size_t n = 0; n + 1 < kTaylor; ++n) r.c[n] = Interval(double(n + 1)) * a.c[n + 1];
  r.c[kTaylor - 1] = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  return r;
}

}  // namespace firn::motion
