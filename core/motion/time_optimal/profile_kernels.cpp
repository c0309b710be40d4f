// The loops over cells and knots of the interior-point method, compiled for the base instruction set and for
// AVX2, and Newton's pentadiagonal system.
#include <algorithm>
#include <cmath>
#include <cstddef>

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

static bool wide() {
  static const bool supported = __builtin_cpu_supports("avx2");
  return supported;
}
#else
namespace avx2 = base;
static bool wide() { return false; }
#endif

}  // namespace profile

double ProfileProblem::assemble(double mu) {
  return profile::wide() ? profile::avx2::assemble(a_, mu, duration_)
                         : profile::base::assemble(a_, mu, duration_);
}

ProfileProblem::Lengths ProfileProblem::step_lengths(double mu, double eta) {
  double primal = 0.0, dual = 0.0;  // largest relative decrease
  for (std::size_t i = 1; i + 1 < n_; ++i) primal = std::max(primal, -a_.step[i] / a_.c[i] * (eta / 0.8));
  profile::wide() ? profile::avx2::steps(a_, mu, primal, dual) : profile::base::steps(a_, mu, primal, dual);
  return {std::min(1.0, eta / std::max(primal, 1e-30)), std::min(1.0, eta / std::max(dual, 1e-30))};
}

void ProfileProblem::move(Lengths l) {
  complementarity_ =
      profile::wide() ? profile::avx2::move(a_, l.primal, l.dual) : profile::base::move(a_, l.primal, l.dual);
}

bool ProfileProblem::solve_step() {
  const std::size_t n = n_;
  const double *const *k = a_.node, *const *a = a_.cell;
  double* step_ = a_.step;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = i > 1 ? 1.0 : 0.0, after = i + 2 < n ? 1.0 : 0.0;
    gradient_[i] = k[0][i + 1] + k[1][i] + before * a[2][i - 1] + a[1][i] + after * a[0][i + 1];
    diagonal_[i] = k[2][i + 1] + k[4][i] + before * a[8][i - 1] + a[6][i] + after * a[3][i + 1];
    upper_1_[i] = k[3][i + 1] + a[7][i] + after * a[4][i + 1];
    upper_2_[i] = after * a[5][i + 1];
  }
  // rest cells: 3 h / sqrt(b)
  const auto rest = [&](std::size_t cell, double h, double weight) {
    const double b = weight * a_.c[cell], slope = -1.5 * h * weight / (b * std::sqrt(b));
    gradient_[cell] += slope;
    diagonal_[cell] -= 1.5 * slope * weight / b;
  };
  rest(1, a_.h[0], a_.b1[1]);
  rest(n - 2, a_.h[n - 1], a_.b0[n - 1]);
  // L D L^T of the pentadiagonal matrix, forward substitution on the way
  double u_before = 0.0, v_before = 0.0, v_before_2 = 0.0, z_before = 0.0, z_before_2 = 0.0;
  double shift_1 = 0.0, shift_diagonal = 0.0,
         shift_diagonal_2 = 0.0;  // subtracted from this row by earlier pivots
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = diagonal_[i] - shift_diagonal, first = i + 2 < n ? upper_1_[i] - shift_1 : 0.0,
                 second = i + 3 < n ? upper_2_[i] : 0.0;
    if (!(pivot > 0.0)) return false;
    const double over = 1.0 / pivot, u = first * over, v = second * over;
    const double z = -gradient_[i] - u_before * z_before - v_before_2 * z_before_2;
    upper_1_[i] = u;
    upper_2_[i] = v;
    step_[i] = z * over;
    shift_diagonal = shift_diagonal_2 + u * first;
    shift_diagonal_2 = v * second;
    shift_1 = u * second;
    v_before_2 = v_before;
    v_before = v;
    u_before = u;
    z_before_2 = z_before;
    z_before = z;
  }
  step_[0] = step_[n - 1] = step_[n] = 0.0;
  for (std::size_t i = n - 2; i > 0; --i) step_[i] -= upper_1_[i] * step_[i + 1] + upper_2_[i] * step_[i + 2];
  return true;
}

}  // namespace firn::motion
