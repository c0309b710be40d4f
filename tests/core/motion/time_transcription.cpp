#include "tests/core/motion/time_transcription.h"

#include <Eigen/Sparse>
#include <Eigen/SparseLU>
#include <algorithm>

namespace firn::motion {

bool TimeTranscription::newton(double weight) {
  const int n = unknowns(), rows = 3 * steps_ + 4;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n + rows);
  for (int k = 0; k < steps_; ++k) right[at(k, 3)] = -1.0;
  for (const Limit& limit : limits_) {
    const Row r = row(limit, z_);
    const double room = r.room();
    double gradient[3];
    for (int i = 0; i < 3; ++i) {
      gradient[i] = 0.0;
      for (int c = 0; c < r.size; ++c) gradient[i] -= 2.0 * r.value[c] * r.slope[c][i];
      right[r.index[i]] += weight / room * gradient[i];
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        double bend = gradient[i] * gradient[j] / room;
        for (int c = 0; c < r.size; ++c) bend += 2.0 * r.slope[c][i] * r.slope[c][j];
        entries.emplace_back(r.index[i], r.index[j], weight / room * bend);
      }
  }
  // a step changes each unknown by no more than about itself
  for (int k = 0; k <= steps_; ++k)
    for (int i = 0; i < (k == steps_ ? 2 : 4); ++i) {
      const double size[4] = {100.0, 500.0, 4000.0, z_[std::size_t(at(std::min(k, steps_ - 1), 3))]};
      entries.emplace_back(at(k, i), at(k, i), 0.1 * weight / (size[i] * size[i]));
    }
  for (int k = 0; k < steps_; ++k) {
    const Dynamics d = dynamics(k, z_);
    for (int e = 0; e < 3; ++e) {
      const int line = n + 3 * k + e;
      right[line] = -d.left[e];
      const auto put = [&](int unknown, double f) {
        entries.emplace_back(line, unknown, f);
        entries.emplace_back(unknown, line, f);
      };
      for (int i = 0; i < 4; ++i)
        if (d.slopes[e][i] != 0.0) put(at(k, i), d.slopes[e][i]);
      if (e > 0) put(at(k + 1, e - 1), 1.0);
    }
  }
  const int fixed[4] = {at(0, 0), at(0, 1), at(steps_, 0), at(steps_, 1)};
  for (int i = 0; i < 4; ++i) {
    entries.emplace_back(n + 3 * steps_ + i, fixed[i], 1.0);
    entries.emplace_back(fixed[i], n + 3 * steps_ + i, 1.0);
  }
  Eigen::SparseMatrix<double> matrix(n + rows, n + rows);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver;
  solver.compute(matrix);
  if (solver.info() != Eigen::Success) return false;
  const Eigen::VectorXd step = solver.solve(right);
  if (!step.allFinite()) return false;
  for (int k = 0; k < steps_; ++k)
    for (int e = 0; e < 3; ++e) price_[e] = std::max(price_[e], 1.5 * std::abs(step[n + 3 * k + e]));
  const double before = merit(z_, weight);
  for (double share = 1.0; share > 1e-6; share *= 0.5) {
    std::vector<double> z = z_;
    for (int i = 0; i < n; ++i) z[std::size_t(i)] += share * step[i];
    const double after = merit(z, weight);
    if (!(after < before)) continue;
    z_ = z;
    return before - after > 0.02 * weight;
  }
  return false;
}

}  // namespace firn::motion
