// SmallLeastSquares solves weighted linear least squares with at most 10 unknowns.
#pragma once

#include <array>
#include <cmath>

namespace firn::vision {

/// Sums of the normal equations in the order of the calls, so that equal input gives equal bytes.
template <int N>
class SmallLeastSquares {
 public:
  using Row = std::array<double, N>;

  void add(const Row& row, double value, double weight) {
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j <= i; ++j) normal_[i][j] += weight * row[i] * row[j];
      right_[i] += weight * row[i] * value;
    }
  }

  /// Cholesky factorisation. @returns false when the unknowns are not determined
  bool solve(Row& x) {
    if (!factor()) return false;
    substitute(right_, x);
    return true;
  }

  /// The variance of sum(row * x) for unit weights' variance 1. @pre solve() returned true
  double variance(const Row& row) const {
    Row z{};
    for (int i = 0; i < N; ++i) {
      double s = row[i];
      for (int j = 0; j < i; ++j) s -= factor_[i][j] * z[j];
      z[i] = s / factor_[i][i];
    }
    double v = 0.0;
    for (double a : z) v += a * a;
    return v;
  }

 private:
  bool factor() {
    for (int i = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j) {
        double s = normal_[i][j];
        for (int k = 0; k < j; ++k) s -= factor_[i][k] * factor_[j][k];
        if (i != j) {
          factor_[i][j] = s / factor_[j][j];
        } else {
          if (!(s > 1e-12 * normal_[i][i]) || !(s > 0.0)) return false;
          factor_[i][i] = std::sqrt(s);
        }
      }
    return true;
  }
  void substitute(const Row& b, Row& x) const {
    Row z{};
    for (int i = 0; i < N; ++i) {
      double s = b[i];
      for (int j = 0; j < i; ++j) s -= factor_[i][j] * z[j];
      z[i] = s / factor_[i][i];
    }
    for (int i = N - 1; i >= 0; --i) {
      double s = z[i];
      for (int j = i + 1; j < N; ++j) s -= factor_[j][i] * x[j];
      x[i] = s / factor_[i][i];
    }
  }

  std::array<Row, N> normal_{}, factor_{};
  Row right_{};
};

}  // namespace firn::vision
