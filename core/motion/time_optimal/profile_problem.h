// ProfileProblem holds the discrete problem of solve_profile: linear forms of the control values, constraint
// terms, Newton system.
//
// Unknowns: c_1 .. c_{n-2}, one per inner cell. At knot i, with l = (1 - a_{i-1}) h_{i-1}, r = a_i h_i,
// a = 1/2 + bend / 12:  b_i = (r c_{i-1} + l c_i) / (l + r),  b'_i = (c_i - c_{i-1}) / (l + r)  (the tangents
// of a cell's two ends meet at c_i). Beside a rest b'_1 = 4 b_1 / (3 h_0), so that c_1 alone decides b_1.
// With a ProfileStart c_0 and c_1 are given: c_2 .. c_{n-2} are unknown, and knot 1 has no constraints.
//
// Constraints f >= 0, all concave in c once 1/sqrt(b) is replaced by its tangent, which lies below it:
//   speed         f = 1 - b / top, where top does not change f = 1 - c / top: c is where the tangents of b
//   meet, so that
//                 b does not exceed top between the knots either
//   acceleration  f = 1 - |Q|^2,            Q = (q'' b + q' b' / 2) / limit
//   jerk          f = R - |L|^2 / R,        L = (q''' b + 3/2 q'' b' + q' b'' / 2) / limit,  R = 1 / sqrt(b)
// one per knot, knot and group, cell end and group. Newton's matrix is pentadiagonal.
#pragma once

#include <cstddef>

#include "core/motion/time_optimal/jerk_profile.h"

namespace firn::motion {

namespace profile {

/// Arrays of one family of constraints: slack, multiplier, gradient in up to three control values, residual.
/// After step_lengths, residual and g0 hold the steps of slack and multiplier.
struct Term {
  double *slack, *multiplier, *g0, *g1, *g2, *residual;
};

/// Arrays of the loops over cells and knots (profile_kernels.cpp), indexed by knot or cell.
struct Loops {
  std::size_t n = 0, groups = 0;  ///< cells; active groups of rows
  bool pair[kMaxGroups] = {};
  double *h, *b0, *b1, *c, *step;
  double *v0, *v1;                 ///< speed forms: f = 1 - v0 c_{i-1} - v1 c_i
  double* q[kMaxGroups][2][2];     ///< acceleration forms: [group][row][control value]
  double* p[2][kMaxGroups][2][3];  ///< jerk forms: [end of the cell][group][row][control value]
  Term speed, acceleration[kMaxGroups], jerk[2][kMaxGroups];
  double *node[5],
      *cell[9];  ///< shares of gradient and matrix: g0 g1 h00 h01 h11; g0 g1 g2 h00 h01 h02 h11 h12 h22
  double *root, *over_root;
};

}  // namespace profile

class ProfileProblem {
 public:
  /// The first `active` groups are active constraints at once. The others may be activated later.
  ProfileProblem(const Curve& curve, const MotionRows& rows, RowGroups& groups, int active,
                 const std::vector<double>& top, const std::vector<double>& bound, const ProfileStart* start,
                 ProfileWork& work);

  /// Residuals, gradients and Newton's matrix at the present point for the barrier parameter mu. Returns the
  /// largest relative violation max(-f).
  double assemble(double mu);
  /// Solves for the step of c. False if the matrix is not positive definite.
  bool solve_step();
  struct Lengths {
    double primal, dual;
  };
  /// Steps of slacks and multipliers that go with it, and how far each may go (fraction eta to the boundary).
  Lengths step_lengths(double mu, double eta);
  void move(Lengths lengths);

  /// Activates each inactive group that exceeds `least` times its acceleration or jerk at a knot. Returns
  /// true if a group was activated.
  bool activate(const MotionRows& rows, double least);
  int groups() const { return int(a_.groups); }  ///< active ones

  double complementarity() const { return complementarity_; }  ///< sum of slack times multiplier
  double duration() const { return duration_; }                ///< sum of h / sqrt(c) when last assembled
  std::size_t terms() const { return (1 + a_.groups) * (n_ - 1) + 2 * a_.groups * (n_ - 2); }
  void result(Profile& out) const;
  /// @pre the first group is the total motion
  void time_gradient(const MotionRows& rows, const std::vector<double>& top, TimeGradient& out) const;

 private:
  void lay_out(ProfileWork& work);
  void set_nodes();
  void set_speeds(const std::vector<double>& top);
  void set_forms(const MotionRows& rows, std::size_t group);
  void first_guess(const Curve& curve, const MotionRows& rows, const std::vector<double>& bound);
  void join(const Curve& curve, double* y) const;
  /// Share of the limits in cell or knot i: a start may exceed them by as much as its solver left it.
  double room(std::size_t i) const;
  void set_first(profile::Term& term, std::size_t i, std::size_t cell, double f, double scale);
  void set_slacks(std::size_t group);
  /// Newton's matrix and right-hand side from the shares of knots and cells.
  void set_system();
  double largest_ratio(const MotionRows& rows, const RowGroup& group) const;
  double square_speed(std::size_t knot) const {
    return a_.b0[knot] * a_.c[knot - 1] + a_.b1[knot] * a_.c[knot];
  }
  double slope(std::size_t knot) const { return m0_[knot] * a_.c[knot - 1] + m1_[knot] * a_.c[knot]; }

  const ProfileStart* start_;  ///< null = from rest
  std::size_t n_, rows_, groups_;
  RowGroup* group_;  ///< the active ones first
  double complementarity_ = 0.0, duration_ = 0.0;
  double *m0_, *m1_, *bend_, *gradient_, *diagonal_, *upper_1_, *upper_2_;
  profile::Loops a_;  ///< the arrays that the loops work on
};

}  // namespace firn::motion
