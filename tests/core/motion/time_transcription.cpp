#include "tests/core/motion/time_transcription.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::motion {
namespace {

/// Linear equations whose matrix has kSide diagonals on either side: elimination with row exchanges.
class BandedEquations {
 public:
  static constexpr int kSide = 6;

  explicit BandedEquations(int count)
      : count_(count), row_(std::size_t(count)), right(std::size_t(count), 0.0) {}

  void add(int i, int j, double value) { row_[std::size_t(i)][std::size_t(j - i + kSide)] += value; }
  /// Makes unknown i zero.
  void fix(int i) {
    for (int j = std::max(0, i - kSide); j <= std::min(count_ - 1, i + kSide); ++j)
      entry(i, j) = entry(j, i) = 0.0;
    entry(i, i) = 1.0;
    right[std::size_t(i)] = 0.0;
  }

  /// Solves into `right`. False: the matrix is singular.
  bool solve() {
    for (int k = 0; k < count_; ++k) {
      const int below = std::min(count_ - 1, k + kSide), end = std::min(count_ - 1, k + 2 * kSide);
      int pivot = k;
      for (int i = k + 1; i <= below; ++i)
        if (std::abs(entry(i, k)) > std::abs(entry(pivot, k))) pivot = i;
      if (!(std::abs(entry(pivot, k)) > 0.0)) return false;
      if (pivot != k) {
        for (int j = k; j <= end; ++j) std::swap(entry(k, j), entry(pivot, j));
        std::swap(right[std::size_t(k)], right[std::size_t(pivot)]);
      }
      for (int i = k + 1; i <= below; ++i) {
        const double share = entry(i, k) / entry(k, k);
        if (share == 0.0) continue;
        for (int j = k; j <= end; ++j) entry(i, j) -= share * entry(k, j);
        right[std::size_t(i)] -= share * right[std::size_t(k)];
      }
    }
    for (int k = count_ - 1; k >= 0; --k) {
      double& x = right[std::size_t(k)];
      for (int j = k + 1; j <= std::min(count_ - 1, k + 2 * kSide); ++j)
        x -= entry(k, j) * right[std::size_t(j)];
      x /= entry(k, k);
      if (!std::isfinite(x)) return false;
    }
    return true;
  }

 private:
  double& entry(int i, int j) { return row_[std::size_t(i)][std::size_t(j - i + kSide)]; }

  int count_;
  std::vector<std::array<double, 3 * kSide + 1>> row_;  ///< fill reaches 2 kSide to the right

 public:
  std::vector<double> right;
};

constexpr int kBlock = 7;  ///< equations of a place: its four unknowns, its step's three multipliers

/// Row of an unknown of TimeTranscription.
int row_of(int unknown) { return unknown / 4 * kBlock + unknown % 4; }

}  // namespace

bool TimeTranscription::newton(double weight) {
  const auto multiplier = [](int k, int e) { return kBlock * k + 4 + e; };
  BandedEquations equations(kBlock * steps_ + 2);
  const auto right = [&](int unknown) -> double& { return equations.right[std::size_t(row_of(unknown))]; };
  for (int k = 0; k < steps_; ++k) right(at(k, 3)) = -1.0;
  for (const Limit& limit : limits_) {
    const Row r = row(limit, z_);
    const double room = r.room();
    double gradient[3];
    for (int i = 0; i < 3; ++i) {
      gradient[i] = 0.0;
      for (int c = 0; c < r.size; ++c) gradient[i] -= 2.0 * r.value[c] * r.slope[c][i];
      right(r.index[i]) += weight / room * gradient[i];
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double bend = gradient[i] * gradient[j] / room;
        for (int c = 0; c < r.size; ++c) bend += 2.0 * r.slope[c][i] * r.slope[c][j];
        equations.add(row_of(r.index[i]), row_of(r.index[j]), weight / room * bend);
      }
  }
  // a step changes each unknown by no more than about itself
  for (int k = 0; k <= steps_; ++k)
    for (int i = 0; i < (k == steps_ ? 2 : 4); ++i) {
      const double size[4] = {100.0, 500.0, 4000.0, z_[std::size_t(at(std::min(k, steps_ - 1), 3))]};
      equations.add(row_of(at(k, i)), row_of(at(k, i)), 0.1 * weight / (size[i] * size[i]));
    }
  for (int k = 0; k < steps_; ++k) {
    const Dynamics d = dynamics(k, z_);
    for (int e = 0; e < 3; ++e) {
      const int line = multiplier(k, e);
      equations.right[std::size_t(line)] = -d.left[e];
      const auto put = [&](int unknown, double f) {
        equations.add(line, row_of(unknown), f);
        equations.add(row_of(unknown), line, f);
      };
      for (int i = 0; i < 4; ++i)
        if (d.slopes[e][i] != 0.0) put(at(k, i), d.slopes[e][i]);
      if (e > 0) put(at(k + 1, e - 1), 1.0);
    }
  }
  for (const int unknown : {at(0, 0), at(0, 1), at(steps_, 0), at(steps_, 1)}) equations.fix(row_of(unknown));
  if (!equations.solve()) return false;
  for (int k = 0; k < steps_; ++k)
    for (int e = 0; e < 3; ++e)
      price_[e] = std::max(price_[e], 1.5 * std::abs(equations.right[std::size_t(multiplier(k, e))]));
  const double before = merit(z_, weight);
  std::vector<double> z(z_.size());
  for (double share = 1.0; share > 1e-6; share *= 0.5) {
    for (int i = 0; i < unknowns(); ++i) z[std::size_t(i)] = z_[std::size_t(i)] + share * right(i);
    const double after = merit(z, weight);
    if (!(after < before)) continue;
    z_ = z;
    return before - after > 0.02 * weight;
  }
  return false;
}

}  // namespace firn::motion
