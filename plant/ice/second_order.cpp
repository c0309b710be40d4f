#include "plant/ice/second_order.h"

#include <numbers>

namespace firn::plant {
namespace {

using Matrix = std::array<std::array<double, 4>, 4>;

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

// Taylor series of a 1024th, squared ten times.
Matrix exponential(Matrix m) {
  constexpr int kSquarings = 10, kTerms = 12;
  for (auto& row : m)
    for (double& v : row) v /= 1 << kSquarings;
  Matrix sum{}, term{};
  for (std::size_t i = 0; i < 4; ++i) sum[i][i] = term[i][i] = 1.0;
  for (int n = 1; n <= kTerms; ++n) {
    term = multiply(term, m);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j) sum[i][j] += (term[i][j] /= n);
  }
  for (int n = 0; n < kSquarings; ++n) sum = multiply(sum, sum);
  return sum;
}

}  // namespace

// With q = x' - b u: x' = q + b u, q' = -w^2 x - 2 zeta w q + (w^2 - 2 zeta w b) u. Augmented by u and its
// increment over the step, so that one exponential holds the response to both ends of a straight input.
SecondOrder::SecondOrder(double hz, double damping, bool rate_input, double step_s) {
  const double w = 2.0 * std::numbers::pi * hz, d = 2.0 * damping * w;
  b_ = rate_input ? d : 0.0;
  Matrix m{};
  m[0] = {0.0, step_s, b_ * step_s, 0.0};
  m[1] = {-w * w * step_s, -d * step_s, (w * w - d * b_) * step_s, 0.0};
  m[2] = {0.0, 0.0, 0.0, 1.0};
  const Matrix e = exponential(m);
  for (std::size_t i = 0; i < 2; ++i) {
    a_[2 * i] = e[i][0];
    a_[2 * i + 1] = e[i][1];
    b1_[i] = e[i][3];
    b0_[i] = e[i][2] - e[i][3];
  }
}

}  // namespace firn::plant
