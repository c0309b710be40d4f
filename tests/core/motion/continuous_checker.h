// Checks a planned segment at every instant, not at samples: interval arithmetic on the curve's cubics, the
// motion's quintics and the arm's closed form, with formulas of its own (no function of core/motion is
// called).
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/motion/certified/certified.h"
#include "tests/core/motion/interval.h"

namespace firn::motion {

/// Proved largest ratios of total, J1, J2: rate, acceleration, jerk.
using NineRatios = std::array<std::array<double, 3>, 3>;

class ContinuousChecker {
 public:
  /// @param elbow ArmConfiguration::elbow
  ContinuousChecker(const StopSegment& segment, const MotionLimits& limits, double link_1, double link_2,
                    int elbow = 1)
      : segment_(segment), link_1_(link_1), link_2_(link_2), elbow_(elbow) {
    const RateLimits* of[3] = {&limits.position, &limits.joint[0], &limits.joint[1]};
    for (std::size_t q = 0; q < 3; ++q) limit_[q] = {of[q]->rate, of[q]->acceleration, of[q]->jerk};
  }

  /// Bounds that are within `sharp` of the truth, or as near as `kDepth` halvings lead; those above 1 within
  /// kCertain; those up to `enough` as they come.
  NineRatios ratios(double sharp, double enough = 0.9) {
    ratio_ = {};
    enough_ = enough;
    sharp_ = sharp;
    const TimedMotion& m = segment_.motion;
    std::size_t cell = 0;
    for (std::size_t k = 0; k + 1 < m.t.size(); ++k) {
      while (cell + 2 < segment_.curve.s.size() && m.s[k] >= segment_.curve.s[cell + 1]) ++cell;
      set_quintic(k);
      halve(0.0, m.t[k + 1] - m.t[k], cell, kDepth);
    }
    return ratio_;
  }

 private:
  static constexpr int kDepth = 26;
  static constexpr double kCertain = 1e-10;

  /// s - s_k of the piece by Newton's divided differences with triple knots at both ends.
  void set_quintic(std::size_t k) {
    const TimedMotion& m = segment_.motion;
    const double T = m.t[k + 1] - m.t[k];
    const double d1 = (m.s[k + 1] - m.s[k]) / T;
    const double a0 = 0.5 * m.a[k], a1 = 0.5 * m.a[k + 1];
    const double b0 = (d1 - m.v[k]) / T, b1 = (m.v[k + 1] - d1) / T;
    const double c0 = (b0 - a0) / T, c1 = (b1 - b0) / T, c2 = (a1 - b1) / T;
    const double e0 = (c1 - c0) / T, e1 = (c2 - c1) / T, f = (e1 - e0) / T;
    // s = v t + a0 t^2 + t^3 (c0 + (t - T) (e0 + f (t - T)))
    start_ = m.s[k];
    power_ = {0.0, m.v[k], a0, c0 - e0 * T + f * T * T, e0 - 2.0 * f * T, f};
  }

  /// Coefficients of the quintic about every instant of the interval. The quintic is moved to the middle
  /// first, so that the powers of a narrow interval are small.
  Taylor path(Interval t) const {
    const double middle = 0.5 * (t.low + t.high);
    std::array<Interval, 6> moved;
    for (std::size_t k = 0; k < 6; ++k) moved[k] = Interval(power_[k]);
    for (std::size_t k = 0; k < 5; ++k)
      for (std::size_t i = 5; i-- > k;) moved[i] = moved[i] + Interval(middle) * moved[i + 1];
    const Interval off = t - Interval(middle);
    Taylor s;
    for (std::size_t n = 0; n < kTaylor; ++n) {
      Interval sum(0.0);
      for (std::size_t k = 6; k-- > n;) {
        double binomial = 1.0;
        for (std::size_t i = 0; i < n; ++i) binomial = binomial * double(k - i) / double(i + 1);
        sum = sum * off + Interval(binomial) * moved[k];
      }
      s.c[n] = sum;
    }
    s.c[0] = s.c[0] + Interval(start_);
    return s;
  }

  /// The cubic of the cell in Bezier form, composed with s(t).
  Taylor along(const std::vector<double>& f, const std::vector<double>& m, std::size_t i, const Taylor& s,
               double shift) const {
    const double h = segment_.curve.s[i + 1] - segment_.curve.s[i];
    const double slope0 = (f[i + 1] - f[i]) / h - h * (2.0 * m[i] + m[i + 1]) / 6.0;
    Taylor u = s;
    u.c[0] = u.c[0] - Interval(segment_.curve.s[i]);
    Taylor r = Interval((m[i + 1] - m[i]) / (6.0 * h)) * u;
    r.c[0] = r.c[0] + Interval(0.5 * m[i]);
    r = r * u;
    r.c[0] = r.c[0] + Interval(slope0);
    r = r * u;
    r.c[0] = r.c[0] + Interval(f[i] + shift);
    return r;
  }

  /// Derivatives of orders 1 to 4 in time at every instant of an interval.
  struct Orders {
    std::array<Interval, 4> x, y, joint[2];
    bool told = true;  ///< the arm may be stretched out: nothing is known of its joints
  };
  Orders orders(Interval t, std::size_t cell) const {
    const Taylor s = path(t);
    const Curve& c = segment_.curve;
    const Taylor x = along(c.x, c.xx, cell, s, 0.0), y = along(c.y, c.yy, cell, s, 0.0);
    const Taylor square = x * x + y * y;
    Taylor cosine = square;
    cosine.c[0] = cosine.c[0] - Interval(link_1_ * link_1_ + link_2_ * link_2_);
    cosine = Interval(1.0 / (2.0 * link_1_ * link_2_)) * cosine;
    Taylor sine_square = Interval(-1.0) * (cosine * cosine);
    sine_square.c[0] = sine_square.c[0] + Interval(1.0);
    Orders out;
    out.told = sine_square.c[0].low > 0.0;
    double factorial = 1.0;
    for (std::size_t n = 1; n <= 4; ++n) {
      factorial *= double(n);
      out.x[n - 1] = Interval(factorial) * x.c[n];
      out.y[n - 1] = Interval(factorial) * y.c[n];
    }
    if (!out.told) return out;
    // theta_2 = acos(cosine), theta_1 = atan2(y, x) - atan2(l2 sin, l1 + l2 cos)
    const Taylor sine = root(sine_square);
    const Taylor second = Interval(-1.0) * (derivative(cosine) / sine);
    const Taylor k2 = Interval(elbow_ * link_2_) * sine;
    Taylor k1 = Interval(link_2_) * cosine;
    k1.c[0] = k1.c[0] + Interval(link_1_);
    const Taylor polar = (x * derivative(y) - y * derivative(x)) / square;
    const Taylor inner = (k1 * derivative(k2) - k2 * derivative(k1)) / square;
    const Taylor first = polar - inner;
    factorial = 1.0;
    for (std::size_t n = 0; n < 4; ++n) {
      factorial *= n > 0 ? double(n) : 1.0;
      out.joint[0][n] = Interval(factorial) * first.c[n];
      out.joint[1][n] = Interval(factorial) * second.c[n];
    }
    return out;
  }

  /// Sizes of orders 1 to 3: the tool's, and the joints'.
  using Sizes = std::array<std::array<Interval, 3>, 3>;
  static Sizes sizes(const Orders& of) {
    Sizes size;
    for (std::size_t n = 0; n < 3; ++n) {
      size[0][n] = root(square(of.x[n]) + square(of.y[n]));
      for (std::size_t j = 0; j < 2; ++j) size[1 + j][n] = of.joint[j][n];
    }
    return size;
  }
  /// The same by the mean value theorem: f(middle) + f'(interval) (t - middle), whose error falls with the
  /// square of the interval's length.
  static Sizes centred(const Orders& of, const Orders& middle, Interval off) {
    Sizes size;
    for (std::size_t n = 0; n < 3; ++n) {
      const Interval slope = Interval(2.0) * (of.x[n] * of.x[n + 1] + of.y[n] * of.y[n + 1]);
      size[0][n] = root(square(middle.x[n]) + square(middle.y[n]) + off * slope);
      for (std::size_t j = 0; j < 2; ++j) size[1 + j][n] = middle.joint[j][n] + off * of.joint[j][n + 1];
    }
    return size;
  }

  /// Ratios of these sizes. Returns whether they are as sharp as asked for.
  bool compare(const Sizes& size, NineRatios& here) const {
    bool sharp = true;
    double scale = 1.0;
    for (std::size_t n = 0; n < 3; ++n) {
      scale *= segment_.factor;
      for (std::size_t q = 0; q < 3; ++q) {
        const Interval& norm = size[q][n];
        here[q][n] = norm.largest() / (limit_[q][n] * scale);
        const double least = norm.low <= 0.0 && norm.high >= 0.0
                                 ? 0.0
                                 : std::min(std::abs(norm.low), std::abs(norm.high)) / (limit_[q][n] * scale);
        const double width = here[q][n] - least;
        sharp = sharp && (here[q][n] <= std::max(std::min(ratio_[q][n], 1.0), enough_) ||
                          width <= (least <= 1.0 && here[q][n] > 1.0 ? std::min(kCertain, sharp_) : sharp_));
      }
    }
    return sharp;
  }

  void halve(double from, double to, std::size_t cell, int depth) {
    const Orders whole = orders({from, to}, cell);
    const double middle = 0.5 * (from + to);
    NineRatios here{};
    bool sharp = false;
    if (whole.told) {
      Sizes size = sizes(whole);
      sharp = compare(size, here);
      if (!sharp) {
        const Sizes other =
            centred(whole, orders(Interval(middle), cell), Interval(from, to) - Interval(middle));
        for (std::size_t q = 0; q < 3; ++q)
          for (std::size_t n = 0; n < 3; ++n) size[q][n] = meet(size[q][n], other[q][n]);
        sharp = compare(size, here);
      }
    }
    if (!sharp && depth > 0) {
      halve(from, middle, cell, depth - 1);
      halve(middle, to, cell, depth - 1);
      return;
    }
    for (std::size_t q = 0; q < 3; ++q)
      for (std::size_t n = 0; n < 3; ++n)
        ratio_[q][n] =
            std::max(ratio_[q][n], whole.told ? here[q][n] : std::numeric_limits<double>::infinity());
  }

  const StopSegment& segment_;
  double link_1_, link_2_, elbow_, start_ = 0.0, sharp_ = 0.0, enough_ = 0.9;
  std::array<double, 6> power_{};
  std::array<std::array<double, 3>, 3> limit_{};
  NineRatios ratio_{};
};

}  // namespace firn::motion
