// The first guess of the speed profile: y = b^(3/4) of the speed-and-acceleration optimum, cut down to the
// slope that jerk allows from a rest, and rounded where it bends.
#include <algorithm>
#include <cmath>

#include "core/motion/time_optimal/profile_problem.h"

namespace firn::motion {
namespace {

/// Rates of a rest: y grows linearly with s under constant jerk, y' = 3 / 2^(3/2) sqrt(jerk).
constexpr double kRestGrowth = 1.0606601717798212;
constexpr double kGuessedShare = 0.8;  ///< of that growth
constexpr double kGuessScale = 0.86;   ///< of b
constexpr double kCapShare = 0.41;     ///< of the jerk limit, for v^3 q'''
/// Half of the length over which y is averaged, in units of y / sqrt(jerk). Where speeding up turns into
/// slowing down, the guess would otherwise ask for many times the jerk.
constexpr double kRounding = 0.35;

double norm_of(const MotionRows& rows, const RowGroup& group, int order, std::size_t at) {
  double sum = 0.0;
  for (int r = group.first; r < group.first + group.count; ++r)
    sum += rows.of[r][order - 1][at] * rows.of[r][order - 1][at];
  return std::sqrt(sum);
}

double power_four_thirds(double y) { return y * std::cbrt(y); }

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
      cap = std::min(cap, kCapShare * group.limit.jerk / (third + 1e-200));
      path = std::min(path, group.limit.jerk / (norm_of(rows, group, 1, right) + 1e-200));
    }
    const double v = std::sqrt(bound[i]);
    y[i] = std::min(v * std::sqrt(v), std::sqrt(cap));
    rate[i] = kGuessedShare * kRestGrowth * std::sqrt(path);
  }
  y[0] = y[n_] = 0.0;
  for (std::size_t i = 0; i < n_; ++i)
    y[i + 1] = std::min(y[i + 1], y[i] + a_.h[i] * std::min(rate[i], rate[i + 1]));
  for (std::size_t i = n_; i-- > 0;)
    y[i] = std::min(y[i], y[i + 1] + a_.h[i] * std::min(rate[i], rate[i + 1]));
  const double* s = curve.s.data();
  sum[0] = 0.0;
  for (std::size_t i = 0; i < n_; ++i) sum[i + 1] = sum[i] + 0.5 * a_.h[i] * (y[i] + y[i + 1]);
  Integral before(s, y, sum, n_), after(s, y, sum, n_);
  const double width = kRounding / std::sqrt(group_[0].limit.jerk);
  rounded[0] = rounded[n_] = 0.0;
  for (std::size_t i = 1; i < n_; ++i) {
    const double w = std::min({width * y[i], s[i], s[n_] - s[i]});
    rounded[i] = w > 1e-9 ? (after(s[i] + w) - before(s[i] - w)) / (2.0 * w) : y[i];
  }
  for (std::size_t i = 1; i + 1 < n_; ++i) {
    a_.c[i] = kGuessScale * power_four_thirds(std::max(0.5 * (rounded[i] + rounded[i + 1]), 1e-9));
    // constant jerk: b'' ~ b^(-1/2), relative change over the cell -(1/2) b' h / b = -(2/3) (change of y) / y
    bend_[i] = std::clamp(-4.0 / 3.0 * (rounded[i + 1] - rounded[i]) / (rounded[i + 1] + rounded[i] + 1e-12),
                          -0.5, 0.5);
  }
}

}  // namespace firn::motion
