// Symmetric3 computes the algebra of symmetric 3 x 3 matrices, by + - * / sqrt alone: same bytes on every
// machine. Not Eigen's: the order of its sums follows the vector instructions of the compiler, and the nodes'
// recorded bytes hold these.
#pragma once

#include <array>

namespace firn::droplet {

struct Symmetric3 {
  std::array<double, 9> m{};  ///< row by row

  double& at(int r, int c) { return m[std::size_t(3 * r + c)]; }
  double at(int r, int c) const { return m[std::size_t(3 * r + c)]; }
  Symmetric3& operator+=(const Symmetric3& o) {
    for (std::size_t n = 0; n < 9; ++n) m[n] += o.m[n];
    return *this;
  }
  std::array<double, 3> times(const std::array<double, 3>& v) const;
  double form(const std::array<double, 3>& v) const;  ///< v' M v
};

double determinant(const Symmetric3& a);
/// @pre determinant not 0
Symmetric3 inverse(const Symmetric3& a);
/// A B A
Symmetric3 sandwich(const Symmetric3& a, const Symmetric3& b);
bool positive_definite(const Symmetric3& a);
/// Smallest eigenvalue of the correlation matrix a_rc / sqrt(a_rr a_cc): 1 = the three directions are seen
/// apart, 0 = one of them is not seen at all.
double separation(const Symmetric3& a);

}  // namespace firn::droplet
