#include "estimators/flow/flow_estimator.h"

#include <nlopt.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/statistics/median.h"

namespace firn::flow {
namespace {

constexpr double kClip = 3.0, kMinFactor = 0.02, kMaxFactor = 5.0;
constexpr int kRounds = 3;  // of fitting with the noise of the residuals before
constexpr unsigned kUnknowns = 4;

struct Aged {
  FlowBlock block;
  double age_layers, weight;
};

double predicted(const Aged& a, const double* x) {
  return (x[0] - x[2] * a.age_layers) * a.block.nominal_mm[0] +
         (x[1] - x[3] * a.age_layers) * a.block.nominal_mm[1];
}

/// Unknowns: f_a, f_b at the newest layer, and their drift per layer.
struct Problem {
  const std::vector<Aged>& blocks;
  const FlowOptions& options;
  double noise_mm;
  std::int64_t evaluations = 0;

  double value(const double* x, double* gradient) {
    ++evaluations;
    double cost = 0.0, g[kUnknowns] = {};
    for (const Aged& b : blocks) {
      const double z = (predicted(b, x) - b.block.rise_mm) / noise_mm;
      const bool far = std::abs(z) > kClip;
      cost += b.weight * (far ? 2.0 * kClip * std::abs(z) - kClip * kClip : z * z);
      const double slope = b.weight * 2.0 * (far ? (z > 0.0 ? kClip : -kClip) : z) / noise_mm;
      for (unsigned v = 0; v < 2; ++v) {
        g[v] += slope * b.block.nominal_mm[v];
        g[v + 2] -= slope * b.block.nominal_mm[v] * b.age_layers;
      }
    }
    const double prior = 1.0 / (options.prior_std * options.prior_std),
                 drift = 1.0 / (options.drift_prior_std * options.drift_prior_std);
    for (unsigned v = 0; v < 2; ++v) {
      cost += prior * (x[v] - 1.0) * (x[v] - 1.0) + drift * x[v + 2] * x[v + 2];
      g[v] += 2.0 * prior * (x[v] - 1.0);
      g[v + 2] += 2.0 * drift * x[v + 2];
    }
    if (gradient) std::copy(g, g + kUnknowns, gradient);
    return cost;
  }
};

double objective(unsigned, const double* x, double* gradient, void* problem) {
  return static_cast<Problem*>(problem)->value(x, gradient);
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
  require(o.blocks.side >= 1 && o.blocks.side <= 100, "blocks.side");
  require(o.blocks.spread >= 0 && o.blocks.spread <= 100, "blocks.spread");
  require(o.blocks.rim >= 0 && o.blocks.rim <= 100, "blocks.rim");
  require(o.least_noise_mm > 0.0, "least_noise_mm");
  require(o.max_evaluations >= 10, "max_evaluations");
  estimate_.factor_std = {o.prior_std, o.prior_std};
}

void FlowEstimator::add(const FlowInterval& interval) {
  for (const HeightMap& n : interval.nominal_mm)
    if (n.spec != interval.rise_mm.spec)
      throw std::invalid_argument("flow estimator: the maps of layer " + std::to_string(interval.layer) +
                                  " have different grids");
  if (!kept_.empty() && interval.layer < kept_.back().layer)
    throw std::invalid_argument("flow estimator: layer " + std::to_string(interval.layer) + " after layer " +
                                std::to_string(kept_.back().layer));
  if (!kept_.empty() && interval.layer == kept_.back().layer) kept_.pop_back();
  kept_.push_back({interval.layer, flow_blocks(interval, options_.blocks)});
  while (int(kept_.size()) > options_.window_intervals) kept_.pop_front();
  fit();
}

void FlowEstimator::fit() {
  std::vector<Aged> blocks;
  for (const Kept& k : kept_) {
    const double age_layers = kept_.back().layer - k.layer, age = age_layers / options_.memory_layers;
    for (const FlowBlock& b : k.blocks)
      blocks.push_back({b, age_layers, b.share / (1.0 + age + 0.5 * age * age)});
  }
  estimate_.intervals = int(kept_.size());
  if (blocks.empty()) return;

  std::array<double, kUnknowns> x{estimate_.factor[0], estimate_.factor[1], estimate_.drift_per_layer[0],
                                  estimate_.drift_per_layer[1]};
  const std::array<double, kUnknowns> low{kMinFactor, kMinFactor, -1.0, -1.0},
      high{kMaxFactor, kMaxFactor, 1.0, 1.0};
  Problem problem{blocks, options_, 0.0};
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> off;
    for (const Aged& b : blocks) off.push_back(std::abs(predicted(b, x.data()) - b.block.rise_mm));
    problem.noise_mm =
        std::max(options_.least_noise_mm, statistics::kMadToStd * statistics::upper_median(off));
    for (unsigned i = 0; i < kUnknowns; ++i) x[i] = std::clamp(x[i], low[i], high[i]);
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(NLOPT_LD_LBFGS, kUnknowns),
                                                                nlopt_destroy);
    nlopt_set_lower_bounds(opt.get(), low.data());
    nlopt_set_upper_bounds(opt.get(), high.data());
    nlopt_set_min_objective(opt.get(), objective, &problem);
    nlopt_set_xtol_abs1(opt.get(), 1e-7);
    nlopt_set_maxeval(opt.get(), options_.max_evaluations / kRounds);
    double value = 0.0;
    nlopt_optimize(opt.get(), x.data(), &value);  // a failure (round-off reached) leaves the best point in x
  }

  Eigen::Matrix4d curvature = Eigen::Matrix4d::Zero();
  double squares = 0.0, weights = 0.0;
  for (const Aged& b : blocks) {
    const double z = (predicted(b, x.data()) - b.block.rise_mm) / problem.noise_mm;
    squares += b.weight * std::min(z * z, kClip * kClip);
    weights += b.weight;
    if (std::abs(z) > kClip) continue;
    const double a = b.block.nominal_mm[0], c = b.block.nominal_mm[1];
    const Eigen::Vector4d slope(a, c, -b.age_layers * a, -b.age_layers * c);
    curvature += b.weight / (problem.noise_mm * problem.noise_mm) * slope * slope.transpose();
  }
  for (int v = 0; v < 2; ++v) {
    curvature(v, v) += 1.0 / (options_.prior_std * options_.prior_std);
    curvature(v + 2, v + 2) += 1.0 / (options_.drift_prior_std * options_.drift_prior_std);
  }
  const Eigen::Vector4d variance = curvature.inverse().diagonal();
  estimate_.fit = weights > 0.0 ? squares / weights : 0.0;
  for (std::size_t v = 0; v < 2; ++v) {
    estimate_.factor[v] = x[v];
    estimate_.drift_per_layer[v] = x[v + 2];
    estimate_.factor_std[v] = std::sqrt(variance[int(v)] * std::max(1.0, estimate_.fit));
  }
  estimate_.evaluations += problem.evaluations;
}

}  // namespace firn::flow
