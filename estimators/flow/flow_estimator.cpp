#include "estimators/flow/flow_estimator.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

namespace firn::flow {
namespace {

constexpr double kClip = 3.0, kMadToStd = 1.4826, kLeastFactor = 0.02, kMostFactor = 5.0;
constexpr int kRounds = 3;  // of fitting with the noise of the residuals before
constexpr unsigned kUnknowns = 4;

double predicted(const FlowEstimator::Block& b, const double* x) {
  return (x[0] - x[2] * b.age_layers) * b.nominal_mm[0] + (x[1] - x[3] * b.age_layers) * b.nominal_mm[1];
}

/// Unknowns: f_a, f_b at the newest layer, and their drift per layer.
struct Problem {
  const std::vector<FlowEstimator::Block>& blocks;
  const FlowOptions& options;
  double noise_mm;
  std::int64_t evaluations = 0;

  double value(const double* x, double* gradient) {
    ++evaluations;
    double cost = 0.0, g[kUnknowns] = {};
    for (const FlowEstimator::Block& b : blocks) {
      const double z = (predicted(b, x) - b.rise_mm) / noise_mm;
      const bool far = std::abs(z) > kClip;
      cost += b.weight * (far ? 2.0 * kClip * std::abs(z) - kClip * kClip : z * z);
      const double slope = b.weight * 2.0 * (far ? (z > 0.0 ? kClip : -kClip) : z) / noise_mm;
      for (unsigned v = 0; v < 2; ++v) {
        g[v] += slope * b.nominal_mm[v];
        g[v + 2] -= slope * b.nominal_mm[v] * b.age_layers;
      }
    }
    const double prior = 1.0 / (options.prior_std * options.prior_std), drift = 1.0 / (options.drift_prior_std * options.drift_prior_std);
    for (unsigned v = 0; v < 2; ++v) {
      cost += prior * (x[v] - 1.0) * (x[v] - 1.0) + drift * x[v + 2] * x[v + 2];
      g[v] += 2.0 * prior * (x[v] - 1.0);
      g[v + 2] += 2.0 * drift * x[v + 2];
    }
    if (gradient) std::copy(g, g + kUnknowns, gradient);
    return cost;
  }
};

double objective(unsigned, const double* x, double* gradient, void* problem) { return static_cast<Problem*>(problem)->value(x, gradient); }

double median(std::vector<double> v) {
  const auto middle = v.begin() + std::ptrdiff_t(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

// Diagonal of the inverse of a small positive definite matrix, by Gauss and Jordan.
std::array<double, kUnknowns> inverse_diagonal(std::array<std::array<double, kUnknowns>, kUnknowns> m) {
  std::array<std::array<double, kUnknowns>, kUnknowns> inverse{};
  for (unsigned i = 0; i < kUnknowns; ++i) inverse[i][i] = 1.0;
  for (unsigned i = 0; i < kUnknowns; ++i) {
    const double pivot = m[i][i];
    for (unsigned k = 0; k < kUnknowns; ++k) m[i][k] /= pivot, inverse[i][k] /= pivot;
    for (unsigned j = 0; j < kUnknowns; ++j) {
      if (j == i) continue;
      const double by = m[j][i];
      for (unsigned k = 0; k < kUnknowns; ++k) m[j][k] -= by * m[i][k], inverse[j][k] -= by * inverse[i][k];
    }
  }
  return {inverse[0][0], inverse[1][1], inverse[2][2], inverse[3][3]};
}

std::vector<FlowEstimator::Block> blocks_of(const FlowInterval& interval, int side) {
  const GridSpec& g = interval.rise_mm.spec;
  std::vector<FlowEstimator::Block> blocks;
  double most = 0.0;
  for (int j = 0; j + side <= g.ny; j += side)
    for (int i = 0; i + side <= g.nx; i += side) {
      FlowEstimator::Block b{};
      for (int y = j; y < j + side; ++y)
        for (int x = i; x < i + side; ++x) {
          b.rise_mm += interval.rise_mm.at(x, y);
          for (std::size_t v = 0; v < 2; ++v) b.nominal_mm[v] += interval.nominal_mm[v].at(x, y);
        }
      const double cells = double(side) * side;
      b.rise_mm /= cells, b.nominal_mm[0] /= cells, b.nominal_mm[1] /= cells;
      most = std::max(most, b.nominal_mm[0] + b.nominal_mm[1]);
      if (std::isfinite(b.rise_mm)) blocks.push_back(b);
    }
  std::erase_if(blocks, [&](const FlowEstimator::Block& b) { return !(b.nominal_mm[0] + b.nominal_mm[1] > 0.1 * most); });
  return blocks;
}

}  // namespace

FlowEstimator::FlowEstimator(const FlowOptions& o) : options_(o) {
  const auto require = [](bool ok, const char* name) {
    if (!ok) throw std::invalid_argument(std::string("flow estimator: ") + name + " is out of its range");
  };
  require(o.prior_std > 0.0 && o.prior_std <= 10.0, "prior_std");
  require(o.drift_prior_std > 0.0 && o.drift_prior_std <= 10.0, "drift_prior_std");
  require(o.memory_layers > 0.0, "memory_layers");
  require(o.window_intervals >= 1, "window_intervals");
  require(o.block_cells >= 1 && o.block_cells <= 100, "block_cells");
  require(o.least_noise_mm > 0.0, "least_noise_mm");
  require(o.max_evaluations >= 10, "max_evaluations");
  estimate_.factor_std = {o.prior_std, o.prior_std};
}

void FlowEstimator::add(const FlowInterval& interval) {
  for (const HeightMap& n : interval.nominal_mm)
    if (n.spec != interval.rise_mm.spec) throw std::invalid_argument("flow estimator: the maps of layer " + std::to_string(interval.layer) + " have different grids");
  if (!kept_.empty() && interval.layer < kept_.back().layer)
    throw std::invalid_argument("flow estimator: layer " + std::to_string(interval.layer) + " after layer " + std::to_string(kept_.back().layer));
  if (!kept_.empty() && interval.layer == kept_.back().layer) kept_.pop_back();
  kept_.push_back({interval.layer, blocks_of(interval, options_.block_cells)});
  while (int(kept_.size()) > options_.window_intervals) kept_.pop_front();
  fit();
}

void FlowEstimator::fit() {
  std::vector<Block> blocks;
  for (const Kept& k : kept_)
    for (Block b : k.blocks) {
      b.age_layers = kept_.back().layer - k.layer;
      b.weight = 1.0 / (1.0 + b.age_layers / options_.memory_layers + 0.5 * b.age_layers * b.age_layers / (options_.memory_layers * options_.memory_layers));
      blocks.push_back(b);
    }
  estimate_.intervals = int(kept_.size());
  if (blocks.empty()) return;

  std::array<double, kUnknowns> x{estimate_.factor[0], estimate_.factor[1], estimate_.drift_per_layer[0], estimate_.drift_per_layer[1]};
  const std::array<double, kUnknowns> low{kLeastFactor, kLeastFactor, -1.0, -1.0}, high{kMostFactor, kMostFactor, 1.0, 1.0};
  Problem problem{blocks, options_, 0.0};
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> off;
    for (const Block& b : blocks) off.push_back(std::abs(predicted(b, x.data()) - b.rise_mm));
    problem.noise_mm = std::max(options_.least_noise_mm, kMadToStd * median(off));
    for (unsigned i = 0; i < kUnknowns; ++i) x[i] = std::clamp(x[i], low[i], high[i]);
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(NLOPT_LD_LBFGS, kUnknowns), nlopt_destroy);
    nlopt_set_lower_bounds(opt.get(), low.data());
    nlopt_set_upper_bounds(opt.get(), high.data());
    nlopt_set_min_objective(opt.get(), objective, &problem);
    nlopt_set_xtol_abs1(opt.get(), 1e-7);
    nlopt_set_maxeval(opt.get(), options_.max_evaluations / kRounds);
    double value = 0.0;
    nlopt_optimize(opt.get(), x.data(), &value);  // a failure (round-off reached) leaves the best point in x
  }

  std::array<std::array<double, kUnknowns>, kUnknowns> curvature{};
  double squares = 0.0, weights = 0.0;
  for (const Block& b : blocks) {
    const double z = (predicted(b, x.data()) - b.rise_mm) / problem.noise_mm;
    squares += b.weight * std::min(z * z, kClip * kClip), weights += b.weight;
    if (std::abs(z) > kClip) continue;
    const double d[kUnknowns] = {b.nominal_mm[0], b.nominal_mm[1], -b.age_layers * b.nominal_mm[0], -b.age_layers * b.nominal_mm[1]};
    for (unsigned i = 0; i < kUnknowns; ++i)
      for (unsigned k = 0; k < kUnknowns; ++k) curvature[i][k] += b.weight * d[i] * d[k] / (problem.noise_mm * problem.noise_mm);
  }
  for (unsigned v = 0; v < 2; ++v) {
    curvature[v][v] += 1.0 / (options_.prior_std * options_.prior_std);
    curvature[v + 2][v + 2] += 1.0 / (options_.drift_prior_std * options_.drift_prior_std);
  }
  const std::array<double, kUnknowns> variance = inverse_diagonal(curvature);
  estimate_.fit = weights > 0.0 ? squares / weights : 0.0;
  for (std::size_t v = 0; v < 2; ++v) {
    estimate_.factor[v] = x[v];
    estimate_.drift_per_layer[v] = x[v + 2];
    estimate_.factor_std[v] = std::sqrt(variance[v] * std::max(1.0, estimate_.fit));
  }
  estimate_.evaluations += problem.evaluations;
}

}  // namespace firn::flow
