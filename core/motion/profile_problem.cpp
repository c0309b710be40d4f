#include "core/motion/profile_problem.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

/// Rates of a rest: y = b^(3/4) grows linearly with s under constant jerk, y' = 3 / 2^(3/2) sqrt(jerk).
constexpr double kRestGrowth = 1.0606601717798212;
constexpr double kGuessedShare = 0.5;  ///< of that growth, in the first guess

/// Where b'' follows b^(-1/2) by a straight line, the jerk inside a cell is above that at its ends by this
/// times bend^2.
constexpr double kBulge = 0.3125;

double square(double v) { return v * v; }

double norm_of(const MotionRows& rows, const RowGroup& group, int order, std::size_t at) {
  double sum = 0.0;
  for (int r = group.first; r < group.first + group.count; ++r) sum += square(rows.of[r][order - 1][at]);
  return std::sqrt(sum);
}

double power_four_thirds(double y) { return y * std::cbrt(y); }

}  // namespace

ProfileProblem::ProfileProblem(const Curve& curve, const MotionRows& rows, const RowGroups& groups,
                               const std::vector<double>& top, const std::vector<double>& bound,
                               ProfileWork& work)
    : n_(curve.cells()), rows_(std::size_t(rows.rows)), groups_(std::size_t(groups.count)) {
  for (std::size_t g = 0; g < groups_; ++g) {
    first_row_[g] = groups.group[g].first;
    row_count_[g] = groups.group[g].count;
  }
  lay_out(work);
  for (std::size_t i = 0; i < n_; ++i) h_[i] = curve.s[i + 1] - curve.s[i];
  for (std::size_t i = 1; i < n_; ++i) over_top_[i] = 1.0 / top[i];
  first_guess(rows, groups, bound);
  set_nodes();
  set_forms(rows, groups);
  first_slacks();
}

void ProfileProblem::lay_out(ProfileWork& work) {
  const std::size_t terms = 1 + groups_ + 2 * groups_;
  work.resize(8 + 8 * rows_ + 6 * terms + 14 + 7, n_ + 4);
  std::size_t next = 0;
  const auto take = [&] { return work.array(next++) + 1; };  // index -1 is valid
  for (double** a : {&h_, &b0_, &b1_, &m0_, &m1_, &over_top_, &bend_, &c_}) *a = take();
  for (std::size_t r = 0; r < rows_; ++r) {
    for (auto& a : q_[r]) a = take();
    for (int side = 0; side < 2; ++side)
      for (auto& a : p_[side][r]) a = take();
  }
  const auto take_term = [&](Term& term) {
    for (double** a : {&term.slack, &term.multiplier, &term.g0, &term.g1, &term.g2, &term.residual})
      *a = take();
  };
  take_term(speed_);
  for (std::size_t g = 0; g < groups_; ++g) {
    take_term(acceleration_[g]);
    take_term(jerk_[0][g]);
    take_term(jerk_[1][g]);
  }
  for (auto& a : node_) a = take();
  for (auto& a : cell_) a = take();
  for (double** a : {&root_, &over_root_, &gradient_, &diagonal_, &upper_1_, &upper_2_, &step_}) *a = take();
}

void ProfileProblem::first_guess(const MotionRows& rows, const RowGroups& groups,
                                 const std::vector<double>& bound) {
  double *y = root_, *rate = over_root_;
  for (std::size_t i = 0; i <= n_; ++i) {
    const std::size_t right = i < n_ ? 2 * i : 2 * n_ - 1, left = i > 0 ? 2 * i - 1 : 0;
    double cap = 1e300, path = 1e300;
    for (std::size_t g = 0; g < groups_; ++g) {
      const RowGroup& group = groups.group[g];
      if (!(group.limit.jerk < kUnlimited)) continue;
      const double third = std::max(norm_of(rows, group, 3, left), norm_of(rows, group, 3, right));
      cap = std::min(cap, 0.5 * group.limit.jerk / (third + 1e-200));  // v^3 q''' <= half of the limit
      path = std::min(path, group.limit.jerk / (norm_of(rows, group, 1, right) + 1e-200));
    }
    const double v = std::sqrt(bound[i]);
    y[i] = std::min(v * std::sqrt(v), std::sqrt(cap));
    rate[i] = kGuessedShare * kRestGrowth * std::sqrt(path);
  }
  y[0] = y[n_] = 0.0;
  for (std::size_t i = 0; i < n_; ++i)
    y[i + 1] = std::min(y[i + 1], y[i] + h_[i] * std::min(rate[i], rate[i + 1]));
  for (std::size_t i = n_; i-- > 0;) y[i] = std::min(y[i], y[i + 1] + h_[i] * std::min(rate[i], rate[i + 1]));
  for (std::size_t i = 1; i + 1 < n_; ++i) {
    c_[i] = 0.8 * power_four_thirds(std::max(0.5 * (y[i] + y[i + 1]), 1e-9));
    // constant jerk: b'' ~ b^(-1/2), relative change over the cell -(1/2) b' h / b = -(2/3) (change of y) / y
    bend_[i] = std::clamp(-4.0 / 3.0 * (y[i + 1] - y[i]) / (y[i + 1] + y[i] + 1e-12), -0.5, 0.5);
  }
}

void ProfileProblem::set_nodes() {
  for (std::size_t i = 1; i < n_; ++i) {
    const double left = (0.5 - bend_[i - 1] / 12.0) * h_[i - 1], right = (0.5 + bend_[i] / 12.0) * h_[i];
    if (i == 1) {  // b_1 + b'_1 right = c_1
      b1_[i] = 1.0 / (1.0 + 4.0 * right / (3.0 * h_[0]));
      m1_[i] = 4.0 / (3.0 * h_[0]) * b1_[i];
    } else if (i == n_ - 1) {
      b0_[i] = 1.0 / (1.0 + 4.0 * left / (3.0 * h_[i]));
      m0_[i] = -4.0 / (3.0 * h_[i]) * b0_[i];
    } else {
      const double over = 1.0 / (left + right);
      b0_[i] = right * over;
      b1_[i] = left * over;
      m0_[i] = -over;
      m1_[i] = over;
    }
  }
}

void ProfileProblem::set_forms(const MotionRows& rows, const RowGroups& groups) {
  for (std::size_t g = 0; g < groups_; ++g) {
    const RowGroup& group = groups.group[g];
    const double over_a = 1.0 / group.limit.acceleration, over_j = 1.0 / group.limit.jerk;
    for (int r = group.first; r < group.first + group.count; ++r) {
      const double *d1 = rows.of[r][0].data(), *d2 = rows.of[r][1].data(), *d3 = rows.of[r][2].data();
      for (std::size_t i = 1; i < n_; ++i) {
        const double e2 = over_a * d2[2 * i], e1 = 0.5 * over_a * d1[2 * i];
        q_[r][0][i] = e2 * b0_[i] + e1 * m0_[i];
        q_[r][1][i] = e2 * b1_[i] + e1 * m1_[i];
      }
      for (int side = 0; side < 2; ++side) {
        double* const* p = p_[side][r];
        for (std::size_t i = 1; i + 1 < n_; ++i) {
          const std::size_t at = 2 * i + std::size_t(side), k = i + std::size_t(side);
          const double over = over_j * (1.0 + kBulge * bend_[i] * bend_[i]);
          const double e3 = over * d3[at], e2 = 1.5 * over * d2[at];
          const double e1 = 0.5 * over * d1[at] / h_[i] * (1.0 + (side ? 0.5 : -0.5) * bend_[i]);
          const double v0 = e3 * b0_[k] + e2 * m0_[k], v1 = e3 * b1_[k] + e2 * m1_[k];
          p[0][i] = (side ? 0.0 : v0) - e1 * m0_[i];
          p[1][i] = (side ? v0 : v1) + e1 * (m0_[i + 1] - m1_[i]);
          p[2][i] = (side ? v1 : 0.0) + e1 * m1_[i + 1];
        }
      }
    }
    // rest cells: jerk = b1^(3/2) / l^2 (q''' x^2 + 2 q'' x + 2/9 q') at the distance x from the rest
    for (int end = 0; end < 2; ++end) {
      const std::size_t knot = end ? n_ - 1 : 1, far = end ? 2 * n_ - 2 : 1, rest = end ? 2 * n_ - 1 : 0;
      const double l = end ? -h_[n_ - 1] : h_[0], over = over_j / (l * l);
      double most = 0.0, at_rest = 0.0;
      for (int r = group.first; r < group.first + group.count; ++r) {
        const double d1 = rows.of[r][0][far], d2 = rows.of[r][1][far], d3 = rows.of[r][2][far];
        most += square(over * (d3 * l * l + 2.0 * d2 * l + 2.0 / 9.0 * d1));
        at_rest += square(over * 2.0 / 9.0 * rows.of[r][0][rest]);
      }
      over_top_[knot] = std::max(over_top_[knot], std::cbrt(std::max(most, at_rest)));  // b1 <= most^(-1/3)
    }
  }
}

void ProfileProblem::first_slacks() {
  const auto set = [&](Term& term, std::size_t i, std::size_t cell, double f, double scale) {
    term.slack[i] = std::max(f, 0.3 * scale);
    term.multiplier[i] = 0.1 * h_[cell] / std::sqrt(c_[cell]) / term.slack[i];
  };
  for (std::size_t i = 1; i < n_; ++i) {
    const std::size_t cell = std::min(i, n_ - 2);
    set(speed_, i, cell, 1.0 - (b0_[i] * c_[i - 1] + b1_[i] * c_[i]) * over_top_[i], 1.0);
    for (std::size_t g = 0; g < groups_; ++g) {
      double f = 1.0;
      for (int r = first_row_[g]; r < first_row_[g] + row_count_[g]; ++r)
        f -= square(q_[r][0][i] * c_[i - 1] + q_[r][1][i] * c_[i]);
      set(acceleration_[g], i, cell, f, 1.0);
    }
  }
  for (std::size_t i = 1; i + 1 < n_; ++i)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t k = i + side;
      const double b = b0_[k] * c_[k - 1] + b1_[k] * c_[k], root = std::sqrt(b);
      for (std::size_t g = 0; g < groups_; ++g) {
        double f = 1.0 / root;
        for (int r = first_row_[g]; r < first_row_[g] + row_count_[g]; ++r) {
          double* const* p = p_[side][r];
          f -= square(p[0][i] * c_[i - 1] + p[1][i] * c_[i] + p[2][i] * c_[i + 1]) * root;
        }
        set(jerk_[side][g], i, i, f, 1.0 / root);
      }
    }
}

void ProfileProblem::result(Profile& out) const {
  out.b.assign(n_ + 1, 0.0);
  out.slope.assign(n_ + 1, 0.0);
  out.bend.assign(bend_, bend_ + n_);
  for (std::size_t i = 1; i < n_; ++i) {
    out.b[i] = b0_[i] * c_[i - 1] + b1_[i] * c_[i];
    out.slope[i] = m0_[i] * c_[i - 1] + m1_[i] * c_[i];
  }
}

}  // namespace firn::motion
