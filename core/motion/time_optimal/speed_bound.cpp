#include "core/motion/time_optimal/speed_bound.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

/// Path accelerations that the limits allow at one sample: [low, high] as functions of b, with their slopes.
struct Window {
  double low, high, low_slope, high_slope;
};

class Sample {
 public:
  /// For a cell of length h at whose left end the sample lies.
  /// |q' a + q'' b| <= bound:  a = -m b +- sqrt((bound^2 - n b^2) / p),  p = q'.q', m = q'.q'' / p, n =
  /// q''.q'' - p m^2
  Sample(const MotionRows& rows, const RowGroups& groups, int active, std::size_t at, double h) {
    for (int g = 0; g < active; ++g) {
      const RowGroup& group = groups.group[g];
      const double bound = group.limit.acceleration;
      if (!(bound < kUnlimited)) continue;
      double p = 0.0, pq = 0.0, q = 0.0;
      for (int r = group.first; r < group.first + group.count; ++r) {
        const double d1 = rows.of[r][0][at], d2 = rows.of[r][1][at];
        p += d1 * d1;
        pq += d1 * d2;
        q += d2 * d2;
      }
      if (p < 1e-30) {
        p = 1e-30;
        pq = 0.0;
      }
      const double over = 1.0 / p, m = pq * over;
      // near a reversal of the joint more b here would mean less b at the next knot, and the sweep forward
      // would not be the fastest motion: without this limit the bound stays one
      if (group.count == 1 && 2.0 * h * std::abs(m) > 1.0) continue;
      limit_[count_++] = {m, (group.count > 1 ? std::max(0.0, q - pq * m) : 0.0) * over,
                          bound * bound * over};
    }
  }

  Window window(double b) const {
    Window w{-1e300, 1e300, 0.0, 0.0};
    for (int k = 0; k < count_; ++k) {
      const Limit& limit = limit_[k];
      const double inside = limit.square - limit.n * b * b;
      if (inside <= 0.0) {  // beyond the largest speed: shrink to it
        const double excess = b - std::sqrt(limit.square / limit.n) * (1.0 - 1e-9);
        return {excess, -excess, 1.0, -1.0};
      }
      const double root = std::sqrt(inside), root_slope = limit.n == 0.0 ? 0.0 : -limit.n * b / root;
      if (-limit.m * b + root < w.high) {
        w.high = -limit.m * b + root;
        w.high_slope = -limit.m + root_slope;
      }
      if (-limit.m * b - root > w.low) {
        w.low = -limit.m * b - root;
        w.low_slope = -limit.m - root_slope;
      }
    }
    return w;
  }

 private:
  struct Limit {
    double m, n, square;
  };
  Limit limit_[kMaxGroups];
  int count_ = 0;
};

/// Largest b in [0, top] from which some acceleration leads into [0, next]: low(b) <= high(b), b + 2 h low(b)
/// <= next, b + 2 h high(b) >= 0. All three are convex in b and hold near 0: Newton from above.
double reach_back(const Sample& sample, double top, double two_h, double next) {
  double b = top;
  for (int step = 0; step < 40; ++step) {
    const Window w = sample.window(b);
    const double excess[3] = {w.low - w.high, b + two_h * w.low - next, -b - two_h * w.high};
    const double slope[3] = {w.low_slope - w.high_slope, 1.0 + two_h * w.low_slope,
                             -1.0 - two_h * w.high_slope};
    double down = 0.0;
    for (int k = 0; k < (excess[0] > 0.0 ? 1 : 3); ++k)
      if (excess[k] > 0.0) down = std::max(down, slope[k] > 0.0 ? excess[k] / slope[k] : 0.5 * b);
    if (down <= 1e-12 * b) return b;
    b = std::max(b - down * (1.0 + 1e-12), 1e-3 * b);
  }
  return b;
}

/// Least time from b0 to b1 over h with path accelerations up to `a` and b up to `top`: up, along, down. b
/// itself is linear in the sweeps; inside a cell the motion may be faster than that.
double shortest_time(double b0, double b1, double h, double a, double top) {
  const double peak = std::max({std::min(top, 0.5 * (b0 + b1) + a * h), b0, b1}), v = std::sqrt(peak);
  const double along = std::max(0.0, h - (2.0 * peak - b0 - b1) / (2.0 * a));
  return (2.0 * v - std::sqrt(b0) - std::sqrt(b1)) / a + (along > 0.0 ? along / v : 0.0);
}

}  // namespace

void speed_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, int active,
                 SpeedBound& bound) {
  const std::size_t n = curve.cells();
  bound.limit.assign(n + 1, 1e300);
  for (int g = 0; g < groups.count; ++g) {
    const RowGroup& group = groups.group[g];
    const double rate = group.limit.rate;
    for (std::size_t i = 0; i <= n; ++i) {
      const std::size_t at = i < n ? 2 * i : 2 * n - 1;
      double p = 0.0;
      for (int r = group.first; r < group.first + group.count; ++r)
        p += rows.of[r][0][at] * rows.of[r][0][at];
      if (rate * rate < bound.limit[i] * p) bound.limit[i] = rate * rate / p;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double c = curve.speed_limit[i] * curve.speed_limit[i];
    bound.limit[i] = std::min(bound.limit[i], c);
    bound.limit[i + 1] = std::min(bound.limit[i + 1], c);
  }
  bound.b.assign(n + 1, 0.0);
  std::vector<Sample> samples;  // of the left ends, for both sweeps
  samples.reserve(n);
  for (std::size_t i = 0; i < n; ++i)
    samples.emplace_back(rows, groups, active, 2 * i, curve.s[i + 1] - curve.s[i]);
  for (std::size_t i = n; i-- > 0;) {
    const double h = curve.s[i + 1] - curve.s[i];
    bound.b[i] = i == 0 ? 0.0 : reach_back(samples[i], bound.limit[i], 2.0 * h, bound.b[i + 1]);
  }
  bound.duration_s = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double h = curve.s[i + 1] - curve.s[i];
    const double highest = bound.b[i] + 2.0 * h * samples[i].window(bound.b[i]).high;
    bound.b[i + 1] = std::min(bound.b[i + 1], std::max(highest, 0.0));
    const double d1x = rows.of[0][0][2 * i], d1y = rows.of[1][0][2 * i];
    const double most = groups.group[0].limit.acceleration / std::sqrt(d1x * d1x + d1y * d1y);
    const double top = std::max({bound.b[i], bound.b[i + 1], std::min(bound.limit[i], bound.limit[i + 1])});
    bound.duration_s += shortest_time(bound.b[i], bound.b[i + 1], h, most, top);
  }
}

}  // namespace firn::motion
