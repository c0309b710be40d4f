// FlowEstimator estimates each valve's flow factor against its calibrated curve Q(nu), and its drift, from
// the commanded volumes and the measured rise of the surface. Coil heat alone raises the flow by up to 20 %
// [Barnett 2012, 5.4, 6.1].
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "estimators/flow/flow_blocks.h"

namespace firn::flow {

struct FlowOptions {
  double prior_std = 0.2;         ///< of a valve's factor about 1
  double drift_prior_std = 0.01;  ///< of its change per layer
  double memory_layers = 30.0;    ///< an interval's weight falls by 1 / e in so many
  int window_intervals = 12;      ///< older ones are forgotten
  BlockOptions blocks;
  double least_noise_mm = 0.01;  ///< of a block's rise
  int max_evaluations = 300;     ///< of the objective, per estimate
};

struct FlowEstimate {
  std::array<double, 2> factor{1.0, 1.0};  ///< flow over that of the calibrated curve, at the newest layer
  std::array<double, 2> factor_std{0.2, 0.2};  ///< standard deviation
  std::array<double, 2> drift_per_layer{};
  double fit = 0.0;  ///< mean square of the residuals over their expected variance; 0 = no data
  int intervals = 0;
  std::int64_t evaluations = 0;  ///< of the objective, since the start
};

/// rise = sum_v (f_v + b_v (layer - newest)) nominal_v + noise, in every block, weighted by its cells; f_v,
/// b_v maximise the posterior with Huber's loss (3 standard deviations), by NLopt's L-BFGS with the exact
/// gradient. The noise is the residuals' own (by their median deviation), at least least_noise_mm. Standard
/// deviations from the curvature at the optimum times sqrt(fit) where that is above 1.
class FlowEstimator {
 public:
  /// @throws std::invalid_argument naming the option
  explicit FlowEstimator(const FlowOptions& options);
  /// An interval of the layer of the last one replaces it (measured again).
  /// @throws std::invalid_argument: grids that differ, a layer before the last one
  void add(const FlowInterval& interval);
  const FlowEstimate& estimate() const { return estimate_; }

 private:
  struct Kept {
    int layer;
    std::vector<FlowBlock> blocks;
  };
  void fit();

  FlowOptions options_;
  std::deque<Kept> kept_;
  FlowEstimate estimate_;
};

}  // namespace firn::flow
