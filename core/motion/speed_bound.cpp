#include "core/motion/speed_bound.h"

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
  Sample(const MotionRows& rows, const RowGroups& groups, std::size_t at)
      : rows_(rows), groups_(groups), at_(at) {}

  Window window(double b) const {
    Window w{-1e300, 1e300, 0.0, 0.0};
    for (int g = 0; g < groups_.count; ++g) {
      const RowGroup& group = groups_.group[g];
      const double bound = group.limit.acceleration;
      if (!(bound < kUnlimited)) continue;
      // |q' a + q'' b| <= bound:  a = -m b +- sqrt((bound^2 - n b^2) / p),  p = q'.q', m = q'.q'' / p, n =
      // q''.q'' - p m^2
      double p = 0.0, pq = 0.0, q = 0.0;
      for (int r = group.first; r < group.first + group.count; ++r) {
        const double d1 = rows_.of[r][0][at_], d2 = rows_.of[r][1][at_];
        p += d1 * d1;
        pq += d1 * d2;
        q += d2 * d2;
      }
      if (p < 1e-30) {
        if (q * b * b > bound * bound) w = {1.0, -1.0, 0.0, -std::sqrt(q) / bound};
        continue;
      }
      const double m = pq / p, n = group.count > 1 ? std::max(0.0, q - pq * m) : 0.0;
      const double inside = bound * bound - n * b * b;
      if (inside <= 0.0) {  // beyond the largest speed: shrink in proportion
        const double best = bound / std::sqrt(n);
        const double excess = (b - best) + 1e-12 * best;
        w.low = std::max(w.low, excess), w.high = -excess, w.low_slope = 1.0, w.high_slope = -1.0;
        return w;
      }
      const double root = std::sqrt(inside / p), root_slope = -n * b / (p * root);
      if (-m * b + root < w.high) w.high = -m * b + root, w.high_slope = -m + root_slope;
      if (-m * b - root > w.low) w.low = -m * b - root, w.low_slope = -m - root_slope;
    }
    return w;
  }

 private:
  const MotionRows& rows_;
  const RowGroups& groups_;
  std::size_t at_;
};

/// Largest b in [0, top] with low(b) <= high(b) and b + 2 h low(b) <= next: both sides are convex, Newton
/// from above.
double reach_back(const Sample& sample, double top, double two_h, double next) {
  double b = top;
  for (int step = 0; step < 30; ++step) {
    const Window w = sample.window(b);
    const double gap = w.low - w.high, over = b + two_h * w.low - next;
    const double gap_slope = w.low_slope - w.high_slope, over_slope = 1.0 + two_h * w.low_slope;
    double down = 0.0;
    if (gap > 0.0) down = gap_slope > 0.0 ? gap / gap_slope : 0.5 * b;
    if (gap <= 0.0 && over > 0.0) down = over_slope > 0.0 ? over / over_slope : 0.5 * b;
    if (down <= 1e-12 * b) return b;
    b = std::max(b - down * (1.0 + 1e-12), 0.0);
  }
  return b;
}

}  // namespace

void speed_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, SpeedBound& bound) {
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
    const double c = curve.ceiling[i] * curve.ceiling[i];
    bound.limit[i] = std::min(bound.limit[i], c);
    bound.limit[i + 1] = std::min(bound.limit[i + 1], c);
  }
  bound.b.assign(n + 1, 0.0);
  for (std::size_t i = n; i-- > 0;) {
    const double h = curve.s[i + 1] - curve.s[i];
    bound.b[i] =
        i == 0 ? 0.0 : reach_back(Sample(rows, groups, 2 * i), bound.limit[i], 2.0 * h, bound.b[i + 1]);
  }
  bound.duration_s = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double h = curve.s[i + 1] - curve.s[i];
    const double highest = bound.b[i] + 2.0 * h * Sample(rows, groups, 2 * i).window(bound.b[i]).high;
    bound.b[i + 1] = std::min(bound.b[i + 1], std::max(highest, 0.0));
    bound.duration_s += 2.0 * h / (std::sqrt(bound.b[i]) + std::sqrt(bound.b[i + 1]));
  }
}

}  // namespace firn::motion
