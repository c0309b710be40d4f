// The loops over cells and knots of the interior-point method, and Newton's pentadiagonal system.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/grid/avx2.h"
#include "core/motion/time_optimal/profile_problem.h"

namespace firn::motion {
namespace profile {
namespace {

// Every loop is element-wise: all instruction sets give the same bytes.

FIRN_INLINE double larger(double a, double b) { return a > b ? a : b; }

/// One speed constraint per knot, linear in its two control values. Sets the knots' shares.
FIRN_INLINE double speed_loop(std::size_t n, double mu, const double* __restrict c,
                              const double* __restrict v0, const double* __restrict v1, Term t,
                              double* const* share) {
  double* __restrict s = t.slack;
  double* __restrict m = t.multiplier;
  double* __restrict t0 = t.g0;
  double* __restrict t1 = t.g1;
  double* __restrict res = t.residual;
  double* __restrict g0 = share[0];
  double* __restrict g1 = share[1];
  double* __restrict h00 = share[2];
  double* __restrict h01 = share[3];
  double* __restrict h11 = share[4];
  double worst = 0.0;
#pragma GCC ivdep
  for (std::size_t i = 1; i < n; ++i) {
    const double d0 = -v0[i], d1 = -v1[i];
    const double f = 1.0 + (d0 * c[i - 1] + d1 * c[i]);
    worst = larger(worst, -f);
    const double r = f - s[i], over = 1.0 / s[i], w = m[i] * over, q = (mu - m[i] * r) * over;
    t0[i] = d0;
    t1[i] = d1;
    res[i] = r;
    g0[i] = -q * d0;
    g1[i] = -q * d1;
    h00[i] = w * d0 * d0;
    h01[i] = w * d0 * d1;
    h11[i] = w * d1 * d1;
  }
  return worst;
}

/// Acceleration of one group of one or two rows: f = 1 - X^2 - Y^2. Adds to the knots' shares.
template <bool kPair>
FIRN_INLINE double acceleration_loop(std::size_t n, double mu, const double* __restrict c,
                                     const double* __restrict x0, const double* __restrict x1,
                                     const double* __restrict y0, const double* __restrict y1, Term t,
                                     double* const* share) {
  double* __restrict s = t.slack;
  double* __restrict m = t.multiplier;
  double* __restrict t0 = t.g0;
  double* __restrict t1 = t.g1;
  double* __restrict res = t.residual;
  double* __restrict g0 = share[0];
  double* __restrict g1 = share[1];
  double* __restrict h00 = share[2];
  double* __restrict h01 = share[3];
  double* __restrict h11 = share[4];
  double worst = 0.0;
#pragma GCC ivdep
  for (std::size_t i = 1; i < n; ++i) {
    const double X = x0[i] * c[i - 1] + x1[i] * c[i], Y = kPair ? y0[i] * c[i - 1] + y1[i] * c[i] : 0.0;
    const double f = 1.0 - X * X - (kPair ? Y * Y : 0.0);
    worst = larger(worst, -f);
    double d0 = X * x0[i], d1 = X * x1[i], a00 = x0[i] * x0[i], a01 = x0[i] * x1[i], a11 = x1[i] * x1[i];
    if (kPair) {
      d0 += Y * y0[i];
      d1 += Y * y1[i];
      a00 += y0[i] * y0[i];
      a01 += y0[i] * y1[i];
      a11 += y1[i] * y1[i];
    }
    d0 *= -2.0;
    d1 *= -2.0;
    const double r = f - s[i], over = 1.0 / s[i], w = m[i] * over, q = (mu - m[i] * r) * over, l = 2.0 * m[i];
    t0[i] = d0;
    t1[i] = d1;
    res[i] = r;
    g0[i] -= q * d0;
    g1[i] -= q * d1;
    h00[i] += w * d0 * d0 + l * a00;
    h01[i] += w * d0 * d1 + l * a01;
    h11[i] += w * d1 * d1 + l * a11;
  }
  return worst;
}

/// sqrt(b) and its inverse at one end of the cells.
FIRN_INLINE void root_loop(std::size_t n, const double* __restrict b0, const double* __restrict b1,
                           const double* __restrict c, double* __restrict root,
                           double* __restrict over_root) {
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double r = std::sqrt(b0[i] * c[i - 1] + b1[i] * c[i]);
    root[i] = r;
    over_root[i] = 1.0 / r;
  }
}

/// The objective's share of the cells: sum of h / sqrt(c), which is returned (in four partial sums).
FIRN_INLINE double objective_loop(std::size_t n, const double* __restrict h, const double* __restrict c,
                                  double* const* share) {
  double* __restrict g0 = share[0];
  double* __restrict g1 = share[1];
  double* __restrict g2 = share[2];
  double* __restrict h00 = share[3];
  double* __restrict h01 = share[4];
  double* __restrict h02 = share[5];
  double* __restrict h11 = share[6];
  double* __restrict h12 = share[7];
  double* __restrict h22 = share[8];
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double over = 1.0 / c[i], slope = -0.5 * h[i] * over * std::sqrt(over);
    g0[i] = g2[i] = h00[i] = h01[i] = h02[i] = h12[i] = h22[i] = 0.0;
    g1[i] = slope;
    h11[i] = -1.5 * slope * over;
  }
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  std::size_t i = 1;
  for (; i + 5 <= n; i += 4)
    for (std::size_t k = 0; k < 4; ++k) sum[k] -= 2.0 * g1[i + k] * c[i + k];
  for (; i + 1 < n; ++i) sum[0] -= 2.0 * g1[i] * c[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Jerk of one group at one end (kRight) of the cells: f = R - (X^2 + Y^2) / R, R = 1 / sqrt(b). Adds to the
/// shares.
/// @param b0, b1 weights of that end's b in its two neighbouring control values
template <bool kPair, bool kRight>
FIRN_INLINE double jerk_loop(std::size_t n, double mu, const double* __restrict c,
                             const double* __restrict b0, const double* __restrict b1,
                             const double* __restrict root, const double* __restrict over_root,
                             double* const* x, double* const* y, Term t, double* const* share) {
  const double* __restrict x0 = x[0];
  const double* __restrict x1 = x[1];
  const double* __restrict x2 = x[2];
  const double* __restrict y0 = y[0];
  const double* __restrict y1 = y[1];
  const double* __restrict y2 = y[2];
  double* __restrict s = t.slack;
  double* __restrict m = t.multiplier;
  double* __restrict t0 = t.g0;
  double* __restrict t1 = t.g1;
  double* __restrict t2 = t.g2;
  double* __restrict res = t.residual;
  double* __restrict g0 = share[0];
  double* __restrict g1 = share[1];
  double* __restrict g2 = share[2];
  double* __restrict h00 = share[3];
  double* __restrict h01 = share[4];
  double* __restrict h02 = share[5];
  double* __restrict h11 = share[6];
  double* __restrict h12 = share[7];
  double* __restrict h22 = share[8];
  double worst = 0.0;
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double S = root[i], R = over_root[i], Rb = -0.5 * R * R * R;
    const double X = x0[i] * c[i - 1] + x1[i] * c[i] + x2[i] * c[i + 1];
    const double Y = kPair ? y0[i] * c[i - 1] + y1[i] * c[i] + y2[i] * c[i + 1] : 0.0;
    double square = X * X, d0 = X * x0[i], d1 = X * x1[i], d2 = X * x2[i];
    if (kPair) {
      square += Y * Y;
      d0 += Y * y0[i];
      d1 += Y * y1[i];
      d2 += Y * y2[i];
    }
    const double f = R - square * S, fb = Rb * (1.0 + square * S * S), S2 = -2.0 * S, k = S * Rb;
    worst = larger(worst, -f * S);
    // p - (L / R) grad R for each row; grad R is nonzero only in the end's two control values
    const double kx = X * k;
    double u0 = x0[i], u1 = x1[i], u2 = x2[i];
    d0 *= S2;
    d1 *= S2;
    d2 *= S2;
    if (kRight) {
      d1 += fb * b0[i];
      d2 += fb * b1[i];
      u1 -= kx * b0[i];
      u2 -= kx * b1[i];
    } else {
      d0 += fb * b0[i];
      d1 += fb * b1[i];
      u0 -= kx * b0[i];
      u1 -= kx * b1[i];
    }
    const double r = f - s[i], over = 1.0 / s[i], w = m[i] * over, q = (mu - m[i] * r) * over, l = -S2 * m[i];
    t0[i] = d0;
    t1[i] = d1;
    t2[i] = d2;
    res[i] = r;
    g0[i] -= q * d0;
    g1[i] -= q * d1;
    g2[i] -= q * d2;
    double a00 = u0 * u0, a01 = u0 * u1, a02 = u0 * u2, a11 = u1 * u1, a12 = u1 * u2, a22 = u2 * u2;
    if (kPair) {
      const double ky = Y * k;
      double v0 = y0[i], v1 = y1[i], v2 = y2[i];
      if (kRight) {
        v1 -= ky * b0[i];
        v2 -= ky * b1[i];
      } else {
        v0 -= ky * b0[i];
        v1 -= ky * b1[i];
      }
      a00 += v0 * v0;
      a01 += v0 * v1;
      a02 += v0 * v2;
      a11 += v1 * v1;
      a12 += v1 * v2;
      a22 += v2 * v2;
    }
    const double w0 = w * d0, w1 = w * d1, w2 = w * d2;
    h00[i] += w0 * d0 + l * a00;
    h01[i] += w0 * d1 + l * a01;
    h02[i] += w0 * d2 + l * a02;
    h11[i] += w1 * d1 + l * a11;
    h12[i] += w1 * d2 + l * a12;
    h22[i] += w2 * d2 + l * a22;
  }
  return worst;
}

/// Steps of slacks and multipliers of one family; the largest relative decreases. Returns nothing else.
template <bool kThree>
FIRN_INLINE void step_loop(std::size_t end, double mu, const double* __restrict d, Term t, double& primal,
                           double& dual) {
  double* __restrict s = t.slack;
  double* __restrict m = t.multiplier;
  double* __restrict t0 = t.g0;
  double* __restrict t1 = t.g1;
  double* __restrict t2 = t.g2;
  double* __restrict res = t.residual;
  double most = primal, most_dual = dual;
#pragma GCC ivdep
  for (std::size_t i = 1; i < end; ++i) {
    double ds = res[i] + t0[i] * d[i - 1] + t1[i] * d[i];
    if (kThree) ds += t2[i] * d[i + 1];
    const double over = 1.0 / (s[i] * m[i]), relative = ds * m[i] * over,
                 relative_m = mu * over - 1.0 - relative;
    most = larger(most, -relative);
    most_dual = larger(most_dual, -relative_m);
    res[i] = ds;
    t0[i] = m[i] * relative_m;
  }
  primal = most;
  dual = most_dual;
}

/// Moves one family and returns the sum of its new products, in four partial sums.
FIRN_INLINE double move_loop(std::size_t end, double primal, double dual, Term t) {
  double* __restrict s = t.slack;
  double* __restrict m = t.multiplier;
  const double* __restrict ds = t.residual, * __restrict dm = t.g0;
#pragma GCC ivdep
  for (std::size_t i = 1; i < end; ++i) {
    s[i] += primal * ds[i];
    m[i] += dual * dm[i];
  }
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  std::size_t i = 1;
  for (; i + 4 <= end; i += 4)
    for (std::size_t k = 0; k < 4; ++k) sum[k] += s[i + k] * m[i + k];
  for (; i < end; ++i) sum[0] += s[i] * m[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

FIRN_CLONES double assemble(const Loops& p, double mu, double& duration) {
  double worst = speed_loop(p.n, mu, p.c, p.v0, p.v1, p.speed, p.node);
  for (std::size_t g = 0; g < p.groups; ++g) {
    double* const* x = p.q[g][0];
    double* const* y = p.q[g][1];
    worst = larger(worst, p.pair[g] ? acceleration_loop<true>(p.n, mu, p.c, x[0], x[1], y[0], y[1],
                                                              p.acceleration[g], p.node)
                                    : acceleration_loop<false>(p.n, mu, p.c, x[0], x[1], x[0], x[1],
                                                               p.acceleration[g], p.node));
  }
  duration = objective_loop(p.n, p.h, p.c, p.cell);
  root_loop(p.n, p.b0, p.b1, p.c, p.root, p.over_root);
  for (std::size_t g = 0; g < p.groups; ++g) {
    double* const* x = p.p[0][g][0];
    double* const* y = p.p[0][g][1];
    worst = larger(worst, p.pair[g] ? jerk_loop<true, false>(p.n, mu, p.c, p.b0, p.b1, p.root, p.over_root, x,
                                                             y, p.jerk[0][g], p.cell)
                                    : jerk_loop<false, false>(p.n, mu, p.c, p.b0, p.b1, p.root, p.over_root,
                                                              x, x, p.jerk[0][g], p.cell));
  }
  root_loop(p.n, p.b0 + 1, p.b1 + 1, p.c + 1, p.root, p.over_root);
  for (std::size_t g = 0; g < p.groups; ++g) {
    double* const* x = p.p[1][g][0];
    double* const* y = p.p[1][g][1];
    worst = larger(worst, p.pair[g] ? jerk_loop<true, true>(p.n, mu, p.c, p.b0 + 1, p.b1 + 1, p.root,
                                                            p.over_root, x, y, p.jerk[1][g], p.cell)
                                    : jerk_loop<false, true>(p.n, mu, p.c, p.b0 + 1, p.b1 + 1, p.root,
                                                             p.over_root, x, x, p.jerk[1][g], p.cell));
  }
  return worst;
}

FIRN_CLONES void steps(const Loops& p, double mu, double& primal, double& dual) {
  step_loop<false>(p.n, mu, p.step, p.speed, primal, dual);
  for (std::size_t g = 0; g < p.groups; ++g) {
    step_loop<false>(p.n, mu, p.step, p.acceleration[g], primal, dual);
    for (int side = 0; side < 2; ++side) step_loop<true>(p.n - 1, mu, p.step, p.jerk[side][g], primal, dual);
  }
}

FIRN_CLONES double move(const Loops& p, double primal, double dual) {
#pragma GCC ivdep
  for (std::size_t i = 1; i + 1 < p.n; ++i) p.c[i] += primal * p.step[i];
  double sum = move_loop(p.n, primal, dual, p.speed);
  for (std::size_t g = 0; g < p.groups; ++g) {
    sum += move_loop(p.n, primal, dual, p.acceleration[g]);
    for (int side = 0; side < 2; ++side) sum += move_loop(p.n - 1, primal, dual, p.jerk[side][g]);
  }
  return sum;
}

}  // namespace
}  // namespace profile

double ProfileProblem::assemble(double mu) { return profile::assemble(a_, mu, duration_); }

ProfileProblem::Lengths ProfileProblem::step_lengths(double mu, double eta) {
  double primal = 0.0, dual = 0.0;  // largest relative decrease
  for (std::size_t i = 1; i + 1 < n_; ++i) primal = std::max(primal, -a_.step[i] / a_.c[i] * (eta / 0.8));
  profile::steps(a_, mu, primal, dual);
  return {std::min(1.0, eta / std::max(primal, 1e-30)), std::min(1.0, eta / std::max(dual, 1e-30))};
}

void ProfileProblem::move(Lengths l) { complementarity_ = profile::move(a_, l.primal, l.dual); }

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
  if (start_) {  // c_1 stays
    gradient_[1] = upper_1_[1] = upper_2_[1] = 0.0;
    diagonal_[1] = 1.0;
  } else {
    rest(1, a_.h[0], a_.b1[1]);
  }
  rest(n - 2, a_.h[n - 1], a_.b0[n - 1]);
  a_.step[0] = a_.step[n - 1] = a_.step[n] = 0.0;
}

namespace {

/// One sweep of elimination: the terms that the rows before subtract from the next two.
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

// L D L^T of the pentadiagonal matrix, forward substitution on the way: from both ends at once, since a row
// waits for the division of the row before; two rows are left in the middle.
bool ProfileProblem::solve_step() {
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
