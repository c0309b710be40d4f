// Minimum time along a curve by direct transcription: an oracle for the planner's speed profiles. Other
// unknowns (speed and acceleration at places, jerk and duration of the steps between them), another method (a
// primal barrier with Gauss-Newton steps) and the arm's closed form by series of its own; of core/motion it
// uses the curve and a motion to start from.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/motion/certified/certified.h"

namespace firn::motion {

/// Taylor coefficients up to s^3.
struct Series {
  std::array<double, 4> c{};

  friend Series operator+(Series a, const Series& b) {
    for (std::size_t n = 0; n < 4; ++n) a.c[n] += b.c[n];
    return a;
  }
  friend Series operator-(Series a, const Series& b) { return a + (-1.0) * b; }
  friend Series operator*(double f, Series a) {
    for (double& v : a.c) v *= f;
    return a;
  }
  friend Series operator*(const Series& a, const Series& b) {
    Series p;
    for (std::size_t n = 0; n < 4; ++n)
      for (std::size_t k = 0; k <= n; ++k) p.c[n] += a.c[k] * b.c[n - k];
    return p;
  }
  friend Series operator/(const Series& a, const Series& b) {
    Series q;
    for (std::size_t n = 0; n < 4; ++n) {
      q.c[n] = a.c[n];
      for (std::size_t k = 0; k < n; ++k) q.c[n] -= q.c[k] * b.c[n - k];
      q.c[n] /= b.c[0];
    }
    return q;
  }
  Series derivative() const { return {{c[1], 2.0 * c[2], 3.0 * c[3], 0.0}}; }
  Series root() const {
    Series r;
    r.c[0] = std::sqrt(c[0]);
    for (std::size_t n = 1; n < 4; ++n) {
      r.c[n] = c[n];
      for (std::size_t k = 1; k < n; ++k) r.c[n] -= r.c[k] * r.c[n - k];
      r.c[n] /= 2.0 * r.c[0];
    }
    return r;
  }
};

class TimeTranscription {
 public:
  /// @param elbow ArmConfiguration::elbow
  TimeTranscription(const StopSegment& segment, const MotionLimits& limits, double link_1, double link_2,
                    int elbow = 1)
      : segment_(segment), link_1_(link_1), link_2_(link_2), elbow_(elbow) {
    const RateLimits* of[3] = {&limits.position, &limits.joint[0], &limits.joint[1]};
    for (std::size_t g = 0; g < 3; ++g) limit_[g] = {of[g]->rate, of[g]->acceleration, of[g]->jerk};
  }

  /// Duration of the best motion found whose limits hold at both ends of `parts` steps of every piece of the
  /// planner's motion: a local optimum, to about `gap` of it. 0 = none was found.
  double minimum_time(int parts, double gap = 2e-4) {
    start(parts);
    double weight = 0.1 * duration(z_) / double(limits_.size());
    for (int round = 0; round < 60; ++round) {
      for (int k = 0; k < 15 && newton(weight); ++k) {
      }
      if (weight * double(limits_.size()) < gap * duration(z_))
        return defect_s(z_) < gap * duration(z_) ? duration(z_) : 0.0;
      weight *= 0.4;
    }
    return 0.0;
  }

 private:
  static constexpr int kPer = 4;  // v, a of a place; jerk and duration of the step behind it
  /// Derivatives of x, y, theta_1, theta_2 with regard to s.
  using Slopes = std::array<std::array<double, 3>, 4>;

  static int at(int k, int n) { return kPer * k + n; }
  int unknowns() const { return kPer * steps_ + 2; }

  Series cubic(const std::vector<double>& f, const std::vector<double>& m, std::size_t i, double s) const {
    const double h = segment_.curve.s[i + 1] - segment_.curve.s[i], u = s - segment_.curve.s[i];
    const double c1 = (f[i + 1] - f[i]) / h - h * (2.0 * m[i] + m[i + 1]) / 6.0, c2 = 0.5 * m[i],
                 c3 = (m[i + 1] - m[i]) / (6.0 * h);
    return {{f[i] + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + 3.0 * c3 * u), c2 + 3.0 * c3 * u, c3}};
  }

  Slopes slopes(std::size_t cell, double s) const {
    const Curve& c = segment_.curve;
    const Series x = cubic(c.x, c.xx, cell, s), y = cubic(c.y, c.yy, cell, s);
    const Series square = x * x + y * y;
    Series cosine = square;
    cosine.c[0] -= link_1_ * link_1_ + link_2_ * link_2_;
    cosine = (0.5 / (link_1_ * link_2_)) * cosine;
    Series rest = (-1.0) * (cosine * cosine);
    rest.c[0] += 1.0;
    const Series sine = rest.root(), k2 = elbow_ * link_2_ * sine;
    Series k1 = link_2_ * cosine;
    k1.c[0] += link_1_;
    const Series second = (-1.0) * (cosine.derivative() / sine);
    const Series first =
        (x * y.derivative() - y * x.derivative() - (k1 * k2.derivative() - k2 * k1.derivative())) / square;
    Slopes q;
    for (std::size_t n = 0; n < 3; ++n) {
      const double lower = n == 2 ? 2.0 : 1.0;
      q[0][n] = lower * double(n + 1) * x.c[n + 1];
      q[1][n] = lower * double(n + 1) * y.c[n + 1];
      q[2][n] = lower * first.c[n];
      q[3][n] = lower * second.c[n];
    }
    return q;
  }

  /// A limit at one end of a step: 1 - |R|^2 > 0 with R = (third v^3 + 3 second v a + first u) / limit, and
  /// lower orders so.
  struct Limit {
    int place, step, group, order;
    Slopes q;
  };

  /// The planner's motion, 2 % slower, and slower still until it keeps every limit with room.
  void start(int parts) {
    const TimedMotion& m = segment_.motion;
    s_.assign(1, 0.0);
    z_.clear();
    limits_.clear();
    const double slow = segment_.factor;
    steps_ = int(m.pieces()) * parts;
    std::size_t cell = 0;
    for (std::size_t piece = 0; piece < m.pieces(); ++piece)
      for (int i = 0; i < parts; ++i) {
        const double length = (m.t[piece + 1] - m.t[piece]) / parts, t = m.t[piece] + i * length;
        const PathState here = m.state(piece, t), next = m.state(piece, t + length);
        const int k = int(s_.size()) - 1;
        while (cell + 2 < segment_.curve.s.size() && 0.5 * (here.s + next.s) >= segment_.curve.s[cell + 1])
          ++cell;
        s_.push_back(k + 1 == steps_ ? segment_.curve.s.back() : next.s);
        const double v = k == 0 ? 0.0 : here.v / slow, a = k == 0 ? 0.0 : here.a / (slow * slow);
        const double end = k + 1 == steps_ ? 0.0 : next.a / (slow * slow);
        z_.insert(z_.end(), {v, a, (end - a) / (slow * length), slow * length});
        for (int side = 0; side < 2; ++side) {
          const Slopes q = slopes(cell, s_[std::size_t(k + side)]);
          for (int group = 0; group < 3; ++group)
            for (int order = side == 0 && k > 0 ? 1 : 3; order <= 3; ++order)
              limits_.push_back({k + side, k, group, order, q});
        }
      }
    z_.insert(z_.end(), {0.0, 0.0});
    for (int tries = 0; tries < 400 && least_room() < 0.05; ++tries)
      for (int k = 0; k <= steps_; ++k) {
        constexpr double kSlow = 1.02;
        z_[std::size_t(at(k, 0))] /= kSlow;
        z_[std::size_t(at(k, 1))] /= kSlow * kSlow;
        if (k == steps_) continue;
        z_[std::size_t(at(k, 2))] /= kSlow * kSlow * kSlow;
        z_[std::size_t(at(k, 3))] *= kSlow;
      }
  }

  struct Row {
    int size = 1;
    double value[2] = {0.0, 0.0};
    int index[3] = {0, 0, 0};  ///< v, a, jerk
    double slope[2][3] = {};
    double room() const { return 1.0 - value[0] * value[0] - value[1] * value[1]; }
  };

  Row row(const Limit& limit, const std::vector<double>& z) const {
    const double v = z[std::size_t(at(limit.place, 0))], a = z[std::size_t(at(limit.place, 1))],
                 u = z[std::size_t(at(limit.step, 2))];
    Row r;
    r.size = limit.group == 0 ? 2 : 1;
    const double over = 1.0 / limit_[std::size_t(limit.group)][std::size_t(limit.order - 1)];
    for (int i = 0; i < r.size; ++i) {
      const auto& d = limit.q[std::size_t(limit.group == 0 ? i : limit.group + 1)];
      double* slope = r.slope[i];
      if (limit.order == 1) {
        r.value[i] = d[0] * v;
        slope[0] = d[0];
      } else if (limit.order == 2) {
        r.value[i] = d[1] * v * v + d[0] * a;
        slope[0] = 2.0 * d[1] * v;
        slope[1] = d[0];
      } else {
        r.value[i] = d[2] * v * v * v + 3.0 * d[1] * v * a + d[0] * u;
        slope[0] = 3.0 * d[2] * v * v + 3.0 * d[1] * a;
        slope[1] = 3.0 * d[1] * v;
        slope[2] = d[0];
      }
      r.value[i] *= over;
      for (int n = 0; n < 3; ++n) slope[n] *= over;
    }
    r.index[0] = at(limit.place, 0);
    r.index[1] = at(limit.place, 1);
    r.index[2] = at(limit.step, 2);
    return r;
  }

  double duration(const std::vector<double>& z) const {
    double sum = 0.0;
    for (int k = 0; k < steps_; ++k) sum += z[std::size_t(at(k, 3))];
    return sum;
  }

  double least_room() const {
    double least = 1.0;
    for (const Limit& limit : limits_) least = std::min(least, row(limit, z_).room());
    return least;
  }

  /// Defects of s, v, a of the next place over a step, in units of the step's length, speed and
  /// acceleration; slopes[n][i] with regard to v, a, u, duration.
  struct Dynamics {
    double left[3];
    double slopes[3][4];
  };
  Dynamics dynamics(int k, const std::vector<double>& z) const {
    const double v = z[std::size_t(at(k, 0))], a = z[std::size_t(at(k, 1))], u = z[std::size_t(at(k, 2))],
                 t = z[std::size_t(at(k, 3))];
    const double next_v = z[std::size_t(at(k + 1, 0))], next_a = z[std::size_t(at(k + 1, 1))];
    return {{s_[std::size_t(k + 1)] - s_[std::size_t(k)] - t * (v + t * (a / 2.0 + t * u / 6.0)),
             next_v - (v + t * (a + t * u / 2.0)), next_a - (a + t * u)},
            {{-t, -t * t / 2.0, -t * t * t / 6.0, -(v + t * (a + t * u / 2.0))},
             {-1.0, -t, -t * t / 2.0, -(a + t * u)},
             {0.0, -1.0, -t, -u}}};
  }

  /// Bound of the worth of the dynamics' defects, by their multipliers.
  double defect_s(const std::vector<double>& z) const {
    double sum = 0.0;
    for (int k = 0; k < steps_; ++k) {
      const Dynamics d = dynamics(k, z);
      for (int n = 0; n < 3; ++n) sum += price_[n] * std::abs(d.left[n]);
    }
    return sum;
  }

  double merit(const std::vector<double>& z, double weight) const {
    for (int k = 0; k < steps_; ++k)
      if (!(z[std::size_t(at(k, 3))] > 0.0)) return 1e300;
    double sum = duration(z) + defect_s(z);
    for (const Limit& limit : limits_) {
      const double room = row(limit, z).room();
      if (!(room > 0.0)) return 1e300;
      sum -= weight * std::log(room);
    }
    return sum;
  }

  /// One step of the barrier problem T - weight sum log(room). False: it no longer gains.
  bool newton(double weight);

  const StopSegment& segment_;
  double link_1_, link_2_, elbow_;
  int steps_ = 0;
  std::array<std::array<double, 3>, 3> limit_{};
  std::vector<double> s_, z_;
  std::vector<Limit> limits_;
  double price_[3] = {0.0, 0.0, 0.0};  ///< largest multiplier of each equation of the dynamics so far
};

}  // namespace firn::motion
