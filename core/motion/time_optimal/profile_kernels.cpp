// The loops over cells and knots of the interior-point method, compiled for the base instruction set and for
// AVX2, and Newton's pentadiagonal system.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/grid/avx2.h"
#include "core/motion/time_optimal/profile_problem.h"

namespace firn::motion {
namespace profile {
namespace base {
#include "core/motion/time_optimal/profile_loops.inc"
}  // namespace base

#ifdef __x86_64__
#pragma GCC push_options
#pragma GCC target("avx2")
namespace avx2 {
#include "core/motion/time_optimal/profile_loops.inc"
}  // namespace avx2
#pragma GCC pop_options
#else
namespace avx2 = base;
#endif

}  // namespace profile

double ProfileProblem::assemble(double mu) {
  return has_avx2() ? profile::avx2::assemble(a_, mu, duration_) : profile::base::assemble(a_, mu, duration_);
}

ProfileProblem::Lengths ProfileProblem::step_lengths(double mu, double eta) {
  double primal = 0.0, dual = 0.0;  // largest relative decrease
  for (std::size_t i = 1; i + 1 < n_; ++i) primal = std::max(primal, -a_.step[i] / a_.c[i] * (eta / 0.8));
  has_avx2() ? profile::avx2::steps(a_, mu, primal, dual) : profile::base::steps(a_, mu, primal, dual);
  return {std::min(1.0, eta / std::max(primal, 1e-30)), std::min(1.0, eta / std::max(dual, 1e-30))};
}

void ProfileProblem::move(Lengths l) {
  complementarity_ =
      has_avx2() ? profile::avx2::move(a_, l.primal, l.dual) : profile::base::move(a_, l.primal, l.dual);
}

void ProfileProblem::set_system() {
  const std::size_t n = n_;
  const double *const *k = a_.node, *const *a = a_.cell;  // cells 0 and n - 1 have no share: zeros
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i)
    gradient_[i] = k[0][i + 1] + k[1][i] + a[2][i - 1] + a[1][i] + a[0][i + 1];
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i)
    diagonal_[i] = k[2][i + 1] + k[4][i] + a[8][i - 1] + a[6][i] + a[3][i + 1];
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i) upper_1_[i] = k[3][i + 1] + a[7][i] + a[4][i + 1];
  std::copy_n(a[5] + 2, n - 2, upper_2_ + 1);
  // rest cells: 3 h / sqrt(b)
  const auto rest = [&](std::size_t cell, double h, double weight) {
    const double b = weight * a_.c[cell], slope = -1.5 * h * weight / (b * std::sqrt(b));
    gradient_[cell] += slope;
    diagonal_[cell] -= 1.5 * slope * weight / b;
  };
  rest(1, a_.h[0], a_.b1[1]);
  rest(n - 2, a_.h[n - 1], a_.b0[n - 1]);
  a_.step[0] = a_.step[n - 1] = a_.step[n] = 0.0;
}

namespace {

/// One sweep of elimination: what the last rows leave to the two that come next.
struct Elimination {
  double u = 0.0, v = 0.0, v_2 = 0.0, z = 0.0, z_2 = 0.0;  ///< of the last row, and the one before
  double shift_1 = 0.0, shift_diagonal = 0.0, shift_diagonal_2 = 0.0;  ///< subtracted from the next rows
  double pivot = 0.0;

  /// Row with these entries, to be divided by its pivot: `first` and `second` become u and v.
  void row(double diagonal, double gradient, double& first, double& second, double& step) {
    pivot = diagonal - shift_diagonal;
    const double f = first - shift_1, over = 1.0 / pivot, next_u = f * over, next_v = second * over;
    const double next_z = -gradient - u * z - v_2 * z_2;
    step = next_z * over;
    shift_diagonal = shift_diagonal_2 + next_u * f;
    shift_diagonal_2 = next_v * second;
    shift_1 = next_u * second;
    v_2 = v;
    v = next_v;
    u = next_u;
    z_2 = z;
    z = next_z;
    first = next_u;
    second = next_v;
  }
};

}  // namespace

// L D L^T of the pentadiagonal matrix, forward substitution on the way.
bool ProfileProblem::solve_step() {
  set_system();
  const std::size_t n = n_;
  double* step_ = a_.step;
  Elimination down;
  upper_1_[n - 2] = upper_2_[n - 2] = upper_2_[n - 3] = 0.0;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    down.row(diagonal_[i], gradient_[i], upper_1_[i], upper_2_[i], step_[i]);
    if (!(down.pivot > 0.0)) return false;
  }
  for (std::size_t i = n - 2; i > 0; --i) step_[i] -= upper_1_[i] * step_[i + 1] + upper_2_[i] * step_[i + 2];
  return true;
}

// From both ends at once, since a row waits for the division of the row before; two rows are left in the
// middle.
bool ProfileProblem::solve_step_from_both_ends() {
  set_system();
  const std::size_t last = n_ - 2, each = (last - 2) / 2, odd = last % 2;
  double *step = a_.step, *first = upper_1_, *second = upper_2_;
  Elimination down, up;
  double least = 1.0;
  for (std::size_t i = 1; i <= each; ++i) {
    const std::size_t j = last + 1 - i;
    down.row(diagonal_[i], gradient_[i], first[i], second[i], step[i]);
    up.row(diagonal_[j], gradient_[j], first[j - 1], second[j - 2], step[j]);
    least = std::min({least, down.pivot, up.pivot});
  }
  const std::size_t a = each + odd + 1, b = a + 1;
  if (odd) {
    down.row(diagonal_[a - 1], gradient_[a - 1], first[a - 1], second[a - 1], step[a - 1]);
    least = std::min(least, down.pivot);
  }
  const double da = diagonal_[a] - down.shift_diagonal - up.shift_diagonal_2,
               db = diagonal_[b] - up.shift_diagonal - down.shift_diagonal_2,
               e = first[a] - down.shift_1 - up.shift_1, det = da * db - e * e;
  if (!(least > 0.0 && da > 0.0 && det > 0.0)) return false;
  const double za = -gradient_[a] - down.u * down.z - down.v_2 * down.z_2 - up.v * up.z,
               zb = -gradient_[b] - up.u * up.z - up.v_2 * up.z_2 - down.v * down.z;
  step[a] = (za * db - zb * e) / det;
  step[b] = (zb * da - za * e) / det;
  if (odd) step[a - 1] -= second[a - 1] * step[b] + first[a - 1] * step[a];
  for (std::size_t i = each; i > 0; --i) {
    const std::size_t j = last + 1 - i;
    step[i] = step[i] - second[i] * step[i + 2] - first[i] * step[i + 1];
    step[j] = step[j] - second[j - 2] * step[j - 2] - first[j - 1] * step[j - 1];
  }
  return true;
}

}  // namespace firn::motion
