#include "core/motion/time_optimal/profile_problem.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"
#include "core/motion/time_optimal/constants.h"

namespace firn::motion {
namespace {

double square(double v) { return v * v; }

double norm_of(const MotionRows& rows, const RowGroup& group, int order, std::size_t at) {
  double sum = 0.0;
  for (int r = group.first; r < group.first + group.count; ++r)
    sum += rows.of[r][order - 1][at] * rows.of[r][order - 1][at];
  return std::sqrt(sum);
}

double power_four_thirds(double y) { return y * exact::cbrt(y); }

/// The integral of a piecewise linear function, asked for at places each near the one before.
class Integral {
 public:
  /// @param sum the integral at the knots s[0 .. n]
  Integral(const double* s, const double* y, const double* sum, std::size_t n)
      : s_(s), y_(y), sum_(sum), n_(n) {}
  double operator()(double at) {
    while (cell_ + 1 < n_ && s_[cell_ + 1] < at) ++cell_;
    while (cell_ > 0 && s_[cell_] > at) --cell_;
    const double u = at - s_[cell_], slope = (y_[cell_ + 1] - y_[cell_]) / (s_[cell_ + 1] - s_[cell_]);
    return sum_[cell_] + u * (y_[cell_] + 0.5 * u * slope);
  }

 private:
  const double *s_, *y_, *sum_;
  std::size_t n_, cell_ = 0;
};

}  // namespace

ProfileProblem::ProfileProblem(const Curve& curve, const MotionRows& rows, RowGroups& groups, int active,
                               const std::vector<double>& top, const std::vector<double>& bound,
                               const ProfileStart* start, ProfileWork& work)
    : start_(start),
      n_(curve.cells()),
      rows_(std::size_t(rows.rows)),
      groups_(std::size_t(groups.count)),
      group_(groups.group) {
  lay_out(work);
  a_.groups = std::size_t(active);
  for (std::size_t i = 0; i < n_; ++i) a_.h[i] = curve.s[i + 1] - curve.s[i];
  first_guess(curve, rows, bound);
  set_nodes();
  set_speeds(top);
  for (std::size_t i = 1; i < n_; ++i)
    set_first(a_.speed, i, std::min(i, n_ - 2), 1.0 - (a_.v0[i] * a_.c[i - 1] + a_.v1[i] * a_.c[i]), 1.0);
  for (std::size_t g = 0; g < a_.groups; ++g) {
    set_forms(rows, g);
    set_slacks(g);
  }
}

void ProfileProblem::lay_out(ProfileWork& work) {
  work.resize(12 + 8 * rows_ + 6 * (1 + 3 * groups_) + 14 + 6, n_ + 4);
  std::size_t next = 0;
  const auto take = [&] { return work.array(next++) + 1; };  // index -1 is valid
  for (double** a :
       {&a_.h, &a_.b0, &a_.b1, &a_.v0, &a_.v1, &a_.c, &a_.step, &a_.root, &a_.over_root, &m0_, &m1_, &bend_})
    *a = take();
  const auto take_term = [&](profile::Term& term) {
    for (double** a : {&term.slack, &term.multiplier, &term.g0, &term.g1, &term.g2, &term.residual})
      *a = take();
  };
  take_term(a_.speed);
  for (std::size_t g = 0; g < groups_; ++g) {
    a_.pair[g] = group_[g].count == 2;
    for (int row = 0; row < group_[g].count; ++row) {
      for (auto& a : a_.q[g][row]) a = take();
      for (int side = 0; side < 2; ++side)
        for (auto& a : a_.p[side][g][row]) a = take();
    }
    take_term(a_.acceleration[g]);
    take_term(a_.jerk[0][g]);
    take_term(a_.jerk[1][g]);
  }
  for (auto& a : a_.node) a = take();
  for (auto& a : a_.cell) a = take();
  for (double** a : {&gradient_, &diagonal_, &upper_1_, &upper_2_}) *a = take();
  a_.n = n_;
}

void ProfileProblem::set_nodes() {
  for (std::size_t i = 1; i < n_; ++i) {
    const double left = (0.5 - bend_[i - 1] / 12.0) * a_.h[i - 1], right = (0.5 + bend_[i] / 12.0) * a_.h[i];
    if (i == 1 && !start_) {  // b_1 + b'_1 right = c_1
      a_.b1[i] = 1.0 / (1.0 + 4.0 * right / (3.0 * a_.h[0]));
      m1_[i] = 4.0 / (3.0 * a_.h[0]) * a_.b1[i];
    } else if (i == n_ - 1) {
      a_.b0[i] = 1.0 / (1.0 + 4.0 * left / (3.0 * a_.h[i]));
      m0_[i] = -4.0 / (3.0 * a_.h[i]) * a_.b0[i];
    } else {
      const double over = 1.0 / (left + right);
      a_.b0[i] = right * over;
      a_.b1[i] = left * over;
      m0_[i] = -over;
      m1_[i] = over;
    }
  }
}

void ProfileProblem::set_speeds(const std::vector<double>& top) {
  const auto like_first = [&](double t) { return std::abs(t - top[1]) <= 1e-9 * top[1]; };
  bool same =
      true;  // from the start: then c_{i-1} is below the same top and b_i, between c_{i-1} and c_i, is too
  for (std::size_t i = 1; i < n_; ++i) {
    const double over = 1.0 / top[i];
    same = same && i < n_ - 1 && like_first(top[i]) && like_first(top[i + 1]);
    a_.v0[i] = same ? 0.0 : over * a_.b0[i];
    a_.v1[i] = same ? over : over * a_.b1[i];
  }
  for (std::size_t i = 1; start_ && i < std::min(kJoinCells, n_); ++i) {
    a_.v0[i] *= i == 1 ? 0.0 : room(i);
    a_.v1[i] *= i == 1 ? 0.0 : room(i);
  }
}

void ProfileProblem::set_forms(const MotionRows& rows, std::size_t g) {
  const RowGroup& group = group_[g];
  const double over_a = 1.0 / group.limit.acceleration, over_j = 1.0 / group.limit.jerk;
  for (int r = group.first; r < group.first + group.count; ++r) {
    const double *d1 = rows.of[r][0].data(), *d2 = rows.of[r][1].data(), *d3 = rows.of[r][2].data();
    for (std::size_t i = 1; i < n_; ++i) {
      const double e2 = over_a * d2[2 * i], e1 = 0.5 * over_a * d1[2 * i];
      a_.q[g][std::size_t(r - group.first)][0][i] = e2 * a_.b0[i] + e1 * m0_[i];
      a_.q[g][std::size_t(r - group.first)][1][i] = e2 * a_.b1[i] + e1 * m1_[i];
    }
    for (int side = 0; side < 2; ++side) {
      double* const* p = a_.p[side][g][r - group.first];
      for (std::size_t i = 1; i + 1 < n_; ++i) {
        const std::size_t at = 2 * i + std::size_t(side), k = i + std::size_t(side);
        const double over = over_j * (1.0 + kJerkBulge * bend_[i] * bend_[i]);
        const double e3 = over * d3[at], e2 = 1.5 * over * d2[at];
        const double e1 = 0.5 * over * d1[at] / a_.h[i] * (1.0 + (side ? 0.5 : -0.5) * bend_[i]);
        const double v0 = e3 * a_.b0[k] + e2 * m0_[k], v1 = e3 * a_.b1[k] + e2 * m1_[k];
        p[0][i] = (side ? 0.0 : v0) - e1 * m0_[i];
        p[1][i] = (side ? v0 : v1) + e1 * (m0_[i + 1] - m1_[i]);
        p[2][i] = (side ? v1 : 0.0) + e1 * m1_[i + 1];
      }
    }
    for (std::size_t i = 1; start_ && i < std::min(kJoinCells, n_ - 1); ++i) {
      const std::size_t row = std::size_t(r - group.first);
      for (double* const q : a_.q[g][row]) q[i] *= i == 1 ? 0.0 : room(i);
      for (int side = 0; side < 2; ++side)
        for (double* const p : a_.p[side][g][row]) p[i] *= room(i);
    }
  }
  // rest cells: jerk = b1^(3/2) / l^2 (q''' x^2 + 2 q'' x + 2/9 q') at the distance x from the rest
  for (int end = start_ ? 1 : 0; end < 2; ++end) {
    const std::size_t knot = end ? n_ - 1 : 1, far = end ? 2 * n_ - 2 : 1, rest = end ? 2 * n_ - 1 : 0;
    const double l = end ? -a_.h[n_ - 1] : a_.h[0], over = over_j / (l * l);
    double most = 0.0, at_rest = 0.0;
    for (int r = group.first; r < group.first + group.count; ++r) {
      const double d1 = rows.of[r][0][far], d2 = rows.of[r][1][far], d3 = rows.of[r][2][far];
      most += square(over * (d3 * l * l + 2.0 * d2 * l + 2.0 / 9.0 * d1));
      at_rest += square(over * 2.0 / 9.0 * rows.of[r][0][rest]);
    }
    const double over_top = exact::cbrt(std::max(most, at_rest));  // b1 <= most^(-1/3)
    if (end)
      a_.v0[knot] = std::max(a_.v0[knot], over_top * a_.b0[knot]);
    else
      a_.v1[knot] = std::max(a_.v1[knot], over_top * a_.b1[knot]);
  }
}

void ProfileProblem::set_first(profile::Term& term, std::size_t i, std::size_t cell, double f, double scale) {
  term.slack[i] = std::max(f, kMinFirstSlack * scale);
  term.multiplier[i] = kFirstProduct * a_.h[cell] / std::sqrt(a_.c[cell]) / term.slack[i];
  complementarity_ += term.slack[i] * term.multiplier[i];
}

void ProfileProblem::set_slacks(std::size_t g) {
  const double* c = a_.c;
  const int count = group_[g].count;
  for (std::size_t i = 1; i < n_; ++i) {
    double f = 1.0;
    for (int row = 0; row < count; ++row)
      f -= square(a_.q[g][row][0][i] * c[i - 1] + a_.q[g][row][1][i] * c[i]);
    set_first(a_.acceleration[g], i, std::min(i, n_ - 2), f, 1.0);
  }
  for (std::size_t i = 1; i + 1 < n_; ++i)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t k = i + side;
      const double root = std::sqrt(a_.b0[k] * c[k - 1] + a_.b1[k] * c[k]);
      double f = 1.0 / root;
      for (int row = 0; row < count; ++row) {
        double* const* p = a_.p[side][g][row];
        f -= square(p[0][i] * c[i - 1] + p[1][i] * c[i] + p[2][i] * c[i + 1]) * root;
      }
      set_first(a_.jerk[side][g], i, i, f, 1.0 / root);
    }
}

double ProfileProblem::largest_ratio(const MotionRows& rows, const RowGroup& group) const {
  double acceleration = 0.0, jerk = 0.0;
  for (std::size_t i = 1; i + 1 < n_; ++i) {
    const double h = a_.h[i], curve = (slope(i + 1) - slope(i)) / h;
    double q = 0.0, p[2] = {0.0, 0.0};
    for (int r = group.first; r < group.first + group.count; ++r) {
      const double *d1 = rows.of[r][0].data() + 2 * i, *d2 = rows.of[r][1].data() + 2 * i,
                   *d3 = rows.of[r][2].data() + 2 * i;
      q += square(d2[0] * square_speed(i) + 0.5 * d1[0] * slope(i));
      for (std::size_t side = 0; side < 2; ++side)
        p[side] += square(d3[side] * square_speed(i + side) + 1.5 * d2[side] * slope(i + side) +
                          0.5 * d1[side] * curve * (1.0 + (side ? 0.5 : -0.5) * bend_[i]));
    }
    acceleration = std::max(acceleration, q);
    jerk = std::max({jerk, p[0] * square_speed(i), p[1] * square_speed(i + 1)});
  }
  return std::sqrt(
      std::max(acceleration / square(group.limit.acceleration), jerk / square(group.limit.jerk)));
}

bool ProfileProblem::activate(const MotionRows& rows, double least) {
  const std::size_t before = a_.groups;
  for (std::size_t g = before; g < groups_; ++g) {
    if (largest_ratio(rows, group_[g]) <= least) continue;
    std::swap(group_[g], group_[a_.groups]);
    set_forms(rows, a_.groups);
    set_slacks(a_.groups);
    ++a_.groups;
  }
  return a_.groups > before;
}

void ProfileProblem::result(Profile& out) const {
  out.b.assign(n_ + 1, 0.0);
  out.slope.assign(n_ + 1, 0.0);
  out.bend.assign(bend_, bend_ + n_);
  if (start_) {
    out.b[0] = start_->b[0];
    out.slope[0] = start_->slope[0];
  }
  for (std::size_t i = 1; i < n_; ++i) {
    out.b[i] = square_speed(i);
    out.slope[i] = slope(i);
  }
}

// The Lagrangian is T - sum m f; by the envelope theorem dT = -sum m df, with c and m held.
void ProfileProblem::time_gradient(const MotionRows& rows, const std::vector<double>& top,
                                   TimeGradient& out) const {
  const RowGroup& group = group_[0];
  const double over_a = 1.0 / group.limit.acceleration, over_j = 1.0 / group.limit.jerk;
  const double rate_2 = square(group.limit.rate);
  for (int r = 0; r < 2; ++r) {
    std::vector<double>* of = r == 0 ? out.x : out.y;
    for (int order = 0; order < 3; ++order) of[order].assign(2 * n_, 0.0);
    const double* d1 = rows.of[r][0].data();
    for (std::size_t i = 1; i < n_; ++i) {
      const double Q = a_.q[0][r][0][i] * a_.c[i - 1] + a_.q[0][r][1][i] * a_.c[i];
      const double d = 2.0 * a_.acceleration[0].multiplier[i] * Q * over_a;
      of[1][2 * i] += d * square_speed(i);
      of[0][2 * i] += 0.5 * d * slope(i);
      const double p = square(rows.of[0][0][2 * i]) + square(rows.of[1][0][2 * i]);
      if (rate_2 <= top[i] * p * (1.0 + 1e-9)) {
        const double used = a_.v0[i] * a_.c[i - 1] + a_.v1[i] * a_.c[i];
        of[0][2 * i] += 2.0 * a_.speed.multiplier[i] * used * d1[2 * i] / p;
      }
    }
    for (std::size_t i = 1; i + 1 < n_; ++i)
      for (std::size_t side = 0; side < 2; ++side) {
        const std::size_t at = 2 * i + side, k = i + side;
        double* const* p = a_.p[side][0][r];
        const double L = p[0][i] * a_.c[i - 1] + p[1][i] * a_.c[i] + p[2][i] * a_.c[i + 1];
        const double b = square_speed(k), over = over_j * (1.0 + kJerkBulge * bend_[i] * bend_[i]);
        const double d = 2.0 * a_.jerk[side][0].multiplier[i] * L * std::sqrt(b) * over;
        of[2][at] += d * b;
        of[1][at] += 1.5 * d * slope(k);
        of[0][at] += 0.5 * d * (slope(i + 1) - slope(i)) / a_.h[i] * (1.0 + (side ? 0.5 : -0.5) * bend_[i]);
      }
  }
}

// The first guess: y = b^(3/4) of the speed-and-acceleration optimum, reduced to the slope that jerk allows
// from a rest, and rounded where it bends.
void ProfileProblem::first_guess(const Curve& curve, const MotionRows& rows,
                                 const std::vector<double>& bound) {
  double *y = a_.root, *rate = a_.over_root, *sum = gradient_, *rounded = diagonal_;
  for (std::size_t i = 0; i <= n_; ++i) {
    const std::size_t right = i < n_ ? 2 * i : 2 * n_ - 1, left = i > 0 ? 2 * i - 1 : 0;
    double cap = 1e300, path = 1e300;
    for (std::size_t g = 0; g < a_.groups; ++g) {
      const RowGroup& group = group_[g];
      if (!(group.limit.jerk < kUnlimited)) continue;
      const double third = std::max(norm_of(rows, group, 3, left), norm_of(rows, group, 3, right));
      cap = std::min(cap, kGuessedThirdShare * group.limit.jerk / (third + 1e-200));
      path = std::min(path, group.limit.jerk / (norm_of(rows, group, 1, right) + 1e-200));
    }
    const double v = std::sqrt(bound[i]);
    y[i] = std::min(v * std::sqrt(v), std::sqrt(cap));
    rate[i] = kGuessedGrowth * kRestGrowth * std::sqrt(path);
  }
  y[n_] = 0.0;
  if (!start_) y[0] = 0.0;
  for (std::size_t i = 0; i < n_; ++i)
    y[i + 1] = std::min(y[i + 1], y[i] + a_.h[i] * std::min(rate[i], rate[i + 1]));
  for (std::size_t i = n_; i-- > 0;)
    y[i] = std::min(y[i], y[i + 1] + a_.h[i] * std::min(rate[i], rate[i + 1]));
  const double* s = curve.s.data();
  sum[0] = 0.0;
  for (std::size_t i = 0; i < n_; ++i) sum[i + 1] = sum[i] + 0.5 * a_.h[i] * (y[i] + y[i + 1]);
  Integral before(s, y, sum, n_), after(s, y, sum, n_);
  const double width = kGuessRounding / std::sqrt(group_[0].limit.jerk);
  rounded[0] = y[0];
  rounded[n_] = 0.0;
  for (std::size_t i = 1; i < n_; ++i) {
    const double w = std::min({width * y[i], s[i], s[n_] - s[i]});
    rounded[i] = w > 1e-9 ? (after(s[i] + w) - before(s[i] - w)) / (2.0 * w) : y[i];
  }
  if (start_) join(curve, rounded);
  for (std::size_t i = 1; i + 1 < n_; ++i) {
    a_.c[i] = kGuessedSquare * power_four_thirds(std::max(0.5 * (rounded[i] + rounded[i + 1]), 1e-9));
    // constant jerk: b'' ~ b^(-1/2), relative change over the cell -(1/2) b' h / b = -(2/3) (change of y) / y
    bend_[i] = std::clamp(-4.0 / 3.0 * (rounded[i + 1] - rounded[i]) / (rounded[i + 1] + rounded[i] + 1e-12),
                          -0.5, 0.5);
  }
  if (!start_) return;
  bend_[0] = std::clamp(-0.5 * (start_->b[1] - start_->b[0]) / start_->b[0], -0.5, 0.5);
  a_.c[0] = start_->b[1] - start_->slope[1] * (0.5 - bend_[0] / 12.0) * a_.h[0];
  a_.c[1] = start_->b[1] + start_->slope[1] * (0.5 + bend_[1] / 12.0) * a_.h[1];
}

/// The guess y = b^(3/4) begins as the profile that it continues, and leaves it gradually.
void ProfileProblem::join(const Curve& curve, double* y) const {
  const std::vector<double>&s = start_->s, &b = start_->ahead;
  std::size_t k = 0;
  for (std::size_t i = 0; i < n_ && curve.s[i] < start_->ahead_mm; ++i) {
    while (k + 2 < s.size() && s[k + 1] <= curve.s[i]) ++k;
    const double u = std::clamp((curve.s[i] - s[k]) / (s[k + 1] - s[k]), 0.0, 1.0);
    const double guess = (b[k] + u * (b[k + 1] - b[k])) / kGuessedSquare, root = std::sqrt(guess);
    const double x = curve.s[i] / start_->ahead_mm, own = x * x * (3.0 - 2.0 * x);
    y[i] = (1.0 - own) * root * std::sqrt(root) + own * y[i];
  }
}

double ProfileProblem::room(std::size_t i) const {
  return 1.0 - kJoinRoom * (1.0 - double(i) / double(kJoinCells));
}

}  // namespace firn::motion
