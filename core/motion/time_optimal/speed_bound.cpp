#include "core/motion/time_optimal/speed_bound.h"

#include <algorithm>
#include <cmath>

#include "core/motion/time_optimal/constants.h"

namespace firn::motion {
namespace {

/// Path accelerations that the limits allow at one sample: [low, high] as functions of b, with their slopes.
struct Window {
  double low, high, low_slope, high_slope;

  void raise_low(double value, double slope) {
    if (value <= low) return;
    low = value;
    low_slope = slope;
  }
  void lower_high(double value, double slope) {
    if (value >= high) return;
    high = value;
    high_slope = slope;
  }
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

  /// Adds a limit: the tool's jerk across the path, sqrt(b) (n.q''' b + 3 n.q'' a) with the unit
  /// normal n, lies within its limit: a = -turn b +- jerk / sqrt(b).
  void set_across(const MotionRows& rows, const RowGroup& tool, std::size_t at) {
    const double x1 = rows.of[0][0][at], y1 = rows.of[1][0][at], x2 = rows.of[0][1][at],
                 y2 = rows.of[1][1][at];
    length_ = std::max(1e-15, std::sqrt(x1 * x1 + y1 * y1));
    over_length_ = 1.0 / length_;
    const double over = over_length_, tx = x1 * over, ty = y1 * over;
    const double second = tx * y2 - ty * x2, third = tx * rows.of[1][2][at] - ty * rows.of[0][2][at];
    along_ = tx * x2 + ty * y2;
    square_curvature_ = second * over * over * second * over * over;
    bends_ = std::abs(second) > kMinCurvature;
    if (!bends_) return;
    turn_ = third / (3.0 * second);
    jerk_ = tool.limit.jerk / (3.0 * std::abs(second));
  }

  double length() const { return length_; }  ///< |q'| of the tool
  double square_curvature() const { return square_curvature_; }
  /// d2s/dt2 at which the tool has that acceleration along the path.
  double path(double acceleration, double b) const { return (acceleration - along_ * b) * over_length_; }
  double path_slope(double slope) const { return (slope - along_) * over_length_; }

  /// b, or the largest that the accelerations allow at all: beyond it a window holds no accelerations.
  double within(double b) const {
    for (int k = 0; k < count_; ++k)
      if (limit_[k].n * b * b >= limit_[k].square)
        b = std::sqrt(limit_[k].square / limit_[k].n) * (1.0 - 1e-9);
    return b;
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
      w.lower_high(-limit.m * b + root, -limit.m + root_slope);
      w.raise_low(-limit.m * b - root, -limit.m - root_slope);
    }
    if (bends_ && b > 0.0) {
      const double over = 1.0 / b, free = jerk_ * std::sqrt(over), slope = 0.5 * free * over;
      w.lower_high(free - turn_ * b, -slope - turn_);
      w.raise_low(-free - turn_ * b, slope - turn_);
    }
    return w;
  }

 private:
  struct Limit {
    double m, n, square;
  };
  Limit limit_[kMaxGroups];
  int count_ = 0;
  bool bends_ = false;
  double turn_ = 0.0, jerk_ = 0.0;
  double length_ = 1.0, over_length_ = 1.0, along_ = 0.0, square_curvature_ = 0.0;
};

/// Least time from b0 to b1 over h with path accelerations up to `a` and b up to `top`: up, along, down. b
/// itself is linear in the sweeps; inside a cell the motion may be faster than that.
double shortest_time(double b0, double b1, double h, double a, double top) {
  const double peak = std::max({std::min(top, 0.5 * (b0 + b1) + a * h), b0, b1}), v = std::sqrt(peak);
  const double along = std::max(0.0, h - (2.0 * peak - b0 - b1) / (2.0 * a));
  return (2.0 * v - std::sqrt(b0) - std::sqrt(b1)) / a + (along > 0.0 ? along / v : 0.0);
}

/// The acceleration along the path that the jerk allows near rest and near the largest speed. With u, a
/// the speed and acceleration along the path and its curvature k, the jerk along the path is j - k^2 u^3. A
/// motion at (u, a > 0) had u >= 0 before: integrating a da = j du, a^2 / 2 <= jerk u + k^2 u^4 / 4 with the
/// largest k so far. It will not exceed its largest speed: a^2 / 2 <= jerk (largest - u). Slowing down
/// mirrors it.
class JerkRoom {
 public:
  JerkRoom(const std::vector<Sample>& samples, const RowGroup& tool, const std::vector<double>& limit,
           bool of_longer)
      : jerk_(tool.limit.jerk), enough_(tool.limit.acceleration * tool.limit.acceleration) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      fastest_ = std::max(fastest_, kBetweenSamples * samples[i].length() * std::sqrt(limit[i]));
    fastest_ = of_longer ? tool.limit.rate : std::min(fastest_, tool.limit.rate);
  }

  /// Largest acceleration along the path that does not lead beyond the largest speed.
  double below_top(const Sample& at, double b) const {
    const double square = 2.0 * jerk_ * (fastest_ - at.length() * std::sqrt(b));
    return square < enough_ ? std::sqrt(std::max(0.0, square)) : kUnlimited;
  }
  /// Lowers b, `two_h` / 2 from where it is `before`, to what the jerk has allowed until there (direction 1)
  /// or will allow (-1).
  /// From above: it is a bound after any number of steps.
  void lower(const Sample& at, double bend, double before, double two_h, double direction, double& b) const {
    for (int step = 0; step < kJerkSteps; ++step) {
      const double u = at.length() * std::sqrt(b), square = u * (2.0 * jerk_ + 0.5 * bend * u * u * u);
      if (!(square < enough_)) return;
      const double allowed =
          before + two_h * std::max(0.0, direction * at.path(direction * std::sqrt(square), b));
      if (allowed >= b) return;
      b = allowed;
    }
  }

 private:
  double jerk_, enough_, fastest_ = 0.0;  ///< enough_: square of the largest acceleration
};

/// Returns the end, by their slopes, of excesses that hold at b and are convex in it: there or little beyond.
double newton_up(double b, const double (&excess)[3], const double (&slope)[3], double top) {
  double up = top - b;
  for (int k = 0; k < 3; ++k)
    if (slope[k] > 0.0) up = std::min(up, -excess[k] / slope[k]);
  return std::min(top, b + up);
}

/// Largest b in [0, top] from which some acceleration leads into [0, next]: low(b) <= high(b), b + 2 h low(b)
/// <= next, b + 2 h high(b) >= 0. All three are convex in b and hold near 0: Newton from above.
/// @param guess where to begin, at most top
double reach_back(const Sample& sample, double top, double two_h, double next, double guess) {
  double b = guess;
  bool above = guess == top;
  for (int step = 0; step < kReachSteps; ++step) {
    const Window w = sample.window(b);
    const double excess[3] = {w.low - w.high, b + two_h * w.low - next, -b - two_h * w.high};
    const double slope[3] = {w.low_slope - w.high_slope, 1.0 + two_h * w.low_slope,
                             -1.0 - two_h * w.high_slope};
    double down = 0.0;
    for (int k = 0; k < (excess[0] > 0.0 ? 1 : 3); ++k)
      if (excess[k] > 0.0) down = std::max(down, slope[k] > 0.0 ? excess[k] / slope[k] : 0.5 * b);
    if (down == 0.0 && !above) {
      b = std::min(top, newton_up(b, excess, slope, top) * (1.0 + kReachClose));
      above = b == top;
      continue;
    }
    if (down <= kReachClose * b && excess[0] <= 0.0) return b;
    above = true;
    if (excess[0] > 0.0) down = std::max(down, kReachInside * b);
    b = std::max(b - down * (1.0 + 1e-12), 1e-3 * b);
  }
  return b;
}

/// The same with accelerations >= least and the jerk across the path. The b with all three are an interval
/// from 0 still (they are convex in b^(3/2)): Newton from above, and false position where a step went beyond
/// the interval's end. Returns that end or, by little, more.
/// @param guess of that end, below top; at or above it = none
double reach_back_bent(const Sample& sample, double top, double two_h, double next, double least,
                       double guess) {
  double gap = kBentFirstGap;  // above a guess that was too low
  double b = std::min(top, guess), above = top, inside = 0.0, excess_above = 0.0, excess_inside = 0.0;
  int side = 0;  // of the last two points: +1 both above, -1 both inside
  for (int step = 0; step < kBentSteps; ++step) {
    Window w = sample.window(b);
    w.raise_low(sample.path(least, b), sample.path_slope(0.0));
    const double excess[3] = {two_h * (w.low - w.high), b + two_h * w.low - next, -b - two_h * w.high};
    const double slope[3] = {two_h * (w.low_slope - w.high_slope), 1.0 + two_h * w.low_slope,
                             -1.0 - two_h * w.high_slope};
    double down = 0.0, most = excess[0];
    for (int k = 0; k < (excess[0] > 0.0 ? 1 : 3); ++k) {
      most = std::max(most, excess[k]);
      if (excess[k] > 0.0) down = std::max(down, slope[k] > 0.0 ? excess[k] / slope[k] : 0.5 * b);
    }
    if (most <= 0.0) {
      if (b == top) return b;
      if (side < 0) excess_above *= 0.5;
      if (excess_above == 0.0) {
        inside = b;
        excess_inside = most;
        b = std::min(top, (1.0 + gap) * newton_up(b, excess, slope, top));
        gap *= kBentGapGrowth;
        continue;
      }
      inside = b;
      excess_inside = most;
      side = -1;
    } else {
      if (side > 0) excess_inside *= 0.5;
      above = b;
      excess_above = most;
      side = inside > 0.0 ? 1 : 0;
      if (down <= kBentClose * b) return b;
    }
    if (above - inside <= kBentClose * above) break;
    if (inside == 0.0)
      b = std::max(b - down, 1e-3 * b);
    else
      b = above - (above - inside) * std::clamp(excess_above / (excess_above - excess_inside), 0.02, 0.98);
  }
  return above;
}

}  // namespace

void speed_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, int active,
                 SpeedBound& bound, const BoundPart& part) {
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
  bound.b[n] = std::min(part.last_b, bound.limit[n]);
  double acceleration = kUnlimited;  // of the cell behind, where the end is not the limit
  for (std::size_t i = n; i-- > 1;) {
    const double two_h = 2.0 * (curve.s[i + 1] - curve.s[i]), next = bound.b[i + 1], top = bound.limit[i];
    const double guess = std::min(top, next + two_h * acceleration);
    const double end = reach_back(samples[i], top, two_h, next, guess > 0.0 ? guess : top);
    bound.b[i] = samples[i].within(end);
    acceleration = bound.b[i] < top ? (bound.b[i] - next) / two_h : kUnlimited;
  }
  bound.b[0] = samples[0].within(std::min(part.first_b, bound.limit[0]));
  for (std::size_t i = 0; i < n; ++i) {
    const Window window = samples[i].window(bound.b[i]);  // beyond the end by little, high may be below low
    const double high = std::max(window.high, window.low);
    const double highest = bound.b[i] + 2.0 * (curve.s[i + 1] - curve.s[i]) * high;
    bound.b[i + 1] = std::min(bound.b[i + 1], std::max(highest, 0.0));
  }
}

void set_duration(const Curve& curve, const MotionRows& rows, const RowGroups& groups, std::size_t first,
                  std::size_t last, SpeedBound& bound) {
  const RowGroup& tool = groups.group[0];
  bound.duration_s = 0.0;
  for (std::size_t i = first; i < last; ++i) {
    const double d1x = rows.of[0][0][2 * i], d1y = rows.of[1][0][2 * i];
    const double most = tool.limit.acceleration / std::sqrt(d1x * d1x + d1y * d1y);
    const double top = std::max({bound.b[i], bound.b[i + 1], std::min(bound.limit[i], bound.limit[i + 1])});
    bound.duration_s += shortest_time(bound.b[i], bound.b[i + 1], curve.s[i + 1] - curve.s[i], most, top);
  }
}

void tighten_bound(const Curve& curve, const MotionRows& rows, const RowGroups& groups, SpeedBound& bound,
                   const BoundPart& part) {
  const std::size_t n = curve.cells();
  const RowGroup& tool = groups.group[0];
  if (!(tool.limit.jerk < kUnlimited)) return;
  std::vector<Sample> samples;
  samples.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    samples.emplace_back(rows, groups, 1, 2 * i, curve.s[i + 1] - curve.s[i]);
    samples.back().set_across(rows, tool, 2 * i);
  }
  const JerkRoom room(samples, tool, bound.limit, part.of_longer);
  double bend = part.square_curvature,
         acceleration = kUnlimited;  // of the cell behind, where b was lowered there
  for (std::size_t i = n; i-- > 1;) {
    const double two_h = 2.0 * (curve.s[i + 1] - curve.s[i]), next = bound.b[i + 1], top = bound.b[i];
    bend = std::max(bend, samples[i].square_curvature());
    const double least = i + 1 < n ? -room.below_top(samples[i + 1], next) : -kUnlimited;
    const double guess = (1.0 + kGuessAbove) * (next + two_h * acceleration);
    double& b = bound.b[i];
    room.lower(samples[i], bend, next, two_h, -1.0, b);
    const double lowered = b;
    b = reach_back_bent(samples[i], b, two_h, next, least, guess > 0.0 ? guess : b);
    b = samples[i].within(b);
    if (b < lowered) room.lower(samples[i], bend, next, two_h, -1.0, b);
    acceleration = b < top ? (b - next) / two_h : kUnlimited;
  }
  bend = part.square_curvature;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double two_h = 2.0 * (curve.s[i + 1] - curve.s[i]), b = bound.b[i];
    const Window window =
        samples[i].window(b);  // b may be above its interval's end by little: then high < low
    const double high =
        std::min(std::max(window.high, window.low), samples[i].path(room.below_top(samples[i], b), b));
    bound.b[i + 1] = std::min(bound.b[i + 1], std::max(b + two_h * high, 0.0));
    bend = std::max(bend, samples[i + 1].square_curvature());
    room.lower(samples[i + 1], bend, b, two_h, 1.0, bound.b[i + 1]);
  }
}

}  // namespace firn::motion
