// The loops over cells and knots of the interior-point method; everything here is element-wise, so that the
// compiler vectorises it and every instruction set gives the same bytes.
#include <algorithm>
#include <cmath>

#include "core/motion/profile_problem.h"

namespace firn::motion {
namespace {

double larger(double a, double b) { return a > b ? a : b; }

}  // namespace

double ProfileProblem::assemble(double mu) {
  double worst = 0.0;
  const std::size_t n = n_;
  const double* __restrict c = c_;
  {
    double* __restrict g0 = node_[0], * __restrict g1 = node_[1], * __restrict h00 = node_[2], * __restrict h01 = node_[3], * __restrict h11 = node_[4];
    const double* __restrict b0 = b0_, * __restrict b1 = b1_, * __restrict top = over_top_;
    const Term t = speed_;
    double* __restrict s = t.slack, * __restrict m = t.multiplier, * __restrict t0 = t.g0, * __restrict t1 = t.g1, * __restrict res = t.residual;
    for (std::size_t i = 1; i < n; ++i) {
      const double f = 1.0 - (b0[i] * c[i - 1] + b1[i] * c[i]) * top[i];
      worst = larger(worst, -f);
      const double d0 = -b0[i] * top[i], d1 = -b1[i] * top[i];
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
    for (std::size_t g = 0; g < groups_; ++g) {
      const Term a = acceleration_[g];
      double* __restrict as = a.slack, * __restrict am = a.multiplier, * __restrict a0 = a.g0, * __restrict a1 = a.g1, * __restrict ares = a.residual;
      const int first = first_row_[g];
      const double* __restrict x0 = q_[first][0], * __restrict x1 = q_[first][1];
      if (row_count_[g] == 2) {
        const double* __restrict y0 = q_[first + 1][0], * __restrict y1 = q_[first + 1][1];
        for (std::size_t i = 1; i < n; ++i) {
          const double X = x0[i] * c[i - 1] + x1[i] * c[i], Y = y0[i] * c[i - 1] + y1[i] * c[i];
          const double f = 1.0 - X * X - Y * Y;
          worst = larger(worst, -f);
          const double d0 = -2.0 * (X * x0[i] + Y * y0[i]), d1 = -2.0 * (X * x1[i] + Y * y1[i]);
          const double r = f - as[i], over = 1.0 / as[i], w = am[i] * over, q = (mu - am[i] * r) * over,
                       l = 2.0 * am[i];
          a0[i] = d0;
          a1[i] = d1;
          ares[i] = r;
          g0[i] -= q * d0;
          g1[i] -= q * d1;
          h00[i] += w * d0 * d0 + l * (x0[i] * x0[i] + y0[i] * y0[i]);
          h01[i] += w * d0 * d1 + l * (x0[i] * x1[i] + y0[i] * y1[i]);
          h11[i] += w * d1 * d1 + l * (x1[i] * x1[i] + y1[i] * y1[i]);
        }
      } else {
        for (std::size_t i = 1; i < n; ++i) {
          const double X = x0[i] * c[i - 1] + x1[i] * c[i];
          const double f = 1.0 - X * X;
          worst = larger(worst, -f);
          const double d0 = -2.0 * X * x0[i], d1 = -2.0 * X * x1[i];
          const double r = f - as[i], over = 1.0 / as[i], w = am[i] * over, q = (mu - am[i] * r) * over,
                       l = 2.0 * am[i];
          a0[i] = d0;
          a1[i] = d1;
          ares[i] = r;
          g0[i] -= q * d0;
          g1[i] -= q * d1;
          h00[i] += w * d0 * d0 + l * x0[i] * x0[i];
          h01[i] += w * d0 * d1 + l * x0[i] * x1[i];
          h11[i] += w * d1 * d1 + l * x1[i] * x1[i];
        }
      }
    }
  }
  double* __restrict g0 = cell_[0], * __restrict g1 = cell_[1], * __restrict g2 = cell_[2];
  double* __restrict h00 = cell_[3], * __restrict h01 = cell_[4], * __restrict h02 = cell_[5], * __restrict h11 = cell_[6], * __restrict h12 = cell_[7], * __restrict h22 = cell_[8];
  {
    const double* __restrict h = h_;
    for (std::size_t i = 1; i + 1 < n; ++i) {  // objective: sum of h / sqrt(c)
      const double over = 1.0 / c[i], slope = -0.5 * h[i] * over * (1.0 / std::sqrt(c[i]));
      g0[i] = g2[i] = h00[i] = h01[i] = h02[i] = h12[i] = h22[i] = 0.0;
      g1[i] = slope;
      h11[i] = -1.5 * slope * over;
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    double* __restrict root = root_, * __restrict over_root = over_root_;
    const double* __restrict b0 = b0_ + side, * __restrict b1 = b1_ + side, * __restrict cs = c_ + side;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double b = b0[i] * cs[i - 1] + b1[i] * cs[i];
      root[i] = std::sqrt(b);
      over_root[i] = 1.0 / root[i];
    }
    for (std::size_t g = 0; g < groups_; ++g) {
      const Term t = jerk_[side][g];
      double* __restrict s = t.slack, * __restrict m = t.multiplier, * __restrict t0 = t.g0, * __restrict t1 = t.g1, * __restrict t2 = t.g2, * __restrict res = t.residual;
      const int first = first_row_[g];
      const double* __restrict x0 = p_[side][first][0], * __restrict x1 = p_[side][first][1], * __restrict x2 = p_[side][first][2];
      const bool two = row_count_[g] == 2;
      const double* __restrict y0 = p_[side][two ? first + 1 : first][0], * __restrict y1 = p_[side][two ? first + 1 : first][1], * __restrict y2 = p_[side][two ? first + 1 : first][2];
      // weights of the knot's b in (c_{i-1}, c_i, c_{i+1})
      const double left = side == 0 ? 1.0 : 0.0, right = 1.0 - left;
      const auto loop = [&](auto pair) {
        for (std::size_t i = 1; i + 1 < n; ++i) {
          const double w0 = left * b0[i], w1 = left * b1[i] + right * b0[i], w2 = right * b1[i];
          const double S = root[i], R = over_root[i], Rb = -0.5 * R * R * R;
          const double X = x0[i] * c[i - 1] + x1[i] * c[i] + x2[i] * c[i + 1];
          double square = X * X, Y = 0.0;
          double e0 = X * x0[i], e1 = X * x1[i], e2 = X * x2[i];
          if constexpr (pair) {
            Y = y0[i] * c[i - 1] + y1[i] * c[i] + y2[i] * c[i + 1];
            square += Y * Y;
            e0 += Y * y0[i], e1 += Y * y1[i], e2 += Y * y2[i];
          }
          const double f = R - square * S, fb = Rb * (1.0 + square * S * S), S2 = -2.0 * S;
          worst = larger(worst, -f * S);
          const double d0 = S2 * e0 + fb * w0, d1 = S2 * e1 + fb * w1, d2 = S2 * e2 + fb * w2;
          const double r = f - s[i], over = 1.0 / s[i], w = m[i] * over, q = (mu - m[i] * r) * over;
          t0[i] = d0;
          t1[i] = d1;
          t2[i] = d2;
          res[i] = r;
          g0[i] -= q * d0;
          g1[i] -= q * d1;
          g2[i] -= q * d2;
          // -Hessian of f with R's own curvature left out: 2 / R (p - (L / R) grad R)(...)^T for each row
          const double l = -S2 * m[i], k = S * Rb;
          const double kx = X * k, u0 = x0[i] - kx * w0, u1 = x1[i] - kx * w1, u2 = x2[i] - kx * w2;
          double a00 = u0 * u0, a01 = u0 * u1, a02 = u0 * u2, a11 = u1 * u1, a12 = u1 * u2, a22 = u2 * u2;
          if constexpr (pair) {
            const double ky = Y * k, v0 = y0[i] - ky * w0, v1 = y1[i] - ky * w1, v2 = y2[i] - ky * w2;
            a00 += v0 * v0, a01 += v0 * v1, a02 += v0 * v2, a11 += v1 * v1, a12 += v1 * v2, a22 += v2 * v2;
          }
          h00[i] += w * d0 * d0 + l * a00;
          h01[i] += w * d0 * d1 + l * a01;
          h02[i] += w * d0 * d2 + l * a02;
          h11[i] += w * d1 * d1 + l * a11;
          h12[i] += w * d1 * d2 + l * a12;
          h22[i] += w * d2 * d2 + l * a22;
        }
      };
      if (two)
        loop(std::true_type{});
      else
        loop(std::false_type{});
    }
  }
  return worst;
}

bool ProfileProblem::solve_step() {
  const std::size_t n = n_;
  const double *const *k = node_, *const *a = cell_;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = i > 1 ? 1.0 : 0.0, after = i + 2 < n ? 1.0 : 0.0;
    gradient_[i] = k[0][i + 1] + k[1][i] + before * a[2][i - 1] + a[1][i] + after * a[0][i + 1];
    diagonal_[i] = k[2][i + 1] + k[4][i] + before * a[8][i - 1] + a[6][i] + after * a[3][i + 1];
    upper_1_[i] = k[3][i + 1] + a[7][i] + after * a[4][i + 1];
    upper_2_[i] = after * a[5][i + 1];
  }
  // rest cells: 3 h / sqrt(b)
  const auto rest = [&](std::size_t cell, double h, double weight) {
    const double b = weight * c_[cell], slope = -1.5 * h * weight / (b * std::sqrt(b));
    gradient_[cell] += slope;
    diagonal_[cell] -= 1.5 * slope * weight / b;
  };
  rest(1, h_[0], b1_[1]);
  rest(n - 2, h_[n - 1], b0_[n - 1]);
  // L D L^T of the pentadiagonal matrix, forward substitution on the way
  double u_before = 0.0, v_before = 0.0, v_before_2 = 0.0, z_before = 0.0, z_before_2 = 0.0;
  double shift_1 = 0.0, shift_diagonal = 0.0,
         shift_diagonal_2 = 0.0;  // what earlier pivots take from this row
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

ProfileProblem::Lengths ProfileProblem::step_lengths(double mu, double eta) {
  const std::size_t n = n_;
  double primal = 0.0, dual = 0.0;  // largest relative decrease
  const double* __restrict d = step_, * __restrict c = c_;
  for (std::size_t i = 1; i + 1 < n; ++i) primal = larger(primal, -d[i] / c[i] * (eta / 0.8));
  const auto family = [&](const Term& t, std::size_t end, auto three) {
    double* __restrict s = t.slack, * __restrict m = t.multiplier, * __restrict t0 = t.g0, * __restrict t1 = t.g1, * __restrict t2 = t.g2, * __restrict res = t.residual;
    for (std::size_t i = 1; i < end; ++i) {
      double ds = res[i] + t0[i] * d[i - 1] + t1[i] * d[i];
      if constexpr (three) ds += t2[i] * d[i + 1];
      const double relative = ds / s[i], relative_m = mu / (s[i] * m[i]) - 1.0 - relative;
      primal = larger(primal, -relative);
      dual = larger(dual, -relative_m);
      res[i] = ds;
      t0[i] = m[i] * relative_m;
    }
  };
  family(speed_, n, std::false_type{});
  for (std::size_t g = 0; g < groups_; ++g) {
    family(acceleration_[g], n, std::false_type{});
    for (int side = 0; side < 2; ++side) family(jerk_[side][g], n - 1, std::true_type{});
  }
  return {std::min(1.0, eta / larger(primal, 1e-30)), std::min(1.0, eta / larger(dual, 1e-30))};
}

void ProfileProblem::move(Lengths lengths) {
  for (std::size_t i = 1; i + 1 < n_; ++i) c_[i] += lengths.primal * step_[i];
  const auto family = [&](const Term& t, std::size_t end) {
    double* __restrict s = t.slack, * __restrict m = t.multiplier;
    const double* __restrict ds = t.residual, * __restrict dm = t.g0;
    for (std::size_t i = 1; i < end; ++i) {
      s[i] += lengths.primal * ds[i];
      m[i] += lengths.dual * dm[i];
    }
  };
  family(speed_, n_);
  for (std::size_t g = 0; g < groups_; ++g) {
    family(acceleration_[g], n_);
    for (int side = 0; side < 2; ++side) family(jerk_[side][g], n_ - 1);
  }
}

double ProfileProblem::complementarity() const {
  double sum = 0.0;
  const auto family = [&](const Term& t, std::size_t end) {
    for (std::size_t i = 1; i < end; ++i) sum += t.slack[i] * t.multiplier[i];
  };
  family(speed_, n_);
  for (std::size_t g = 0; g < groups_; ++g) {
    family(acceleration_[g], n_);
    for (int side = 0; side < 2; ++side) family(jerk_[side][g], n_ - 1);
  }
  return sum;
}

double ProfileProblem::duration() const {
  double sum = 0.0;
  for (std::size_t i = 1; i + 1 < n_; ++i) sum += h_[i] / std::sqrt(c_[i]);
  return sum;
}

}  // namespace firn::motion
