// tune_smf() computes the gains of surface-mapping feedback with the least RMS error for a disturbance
// [Barnett 2012, 5.6].
#pragma once

#include <span>
#include <string_view>

#include "core/control/smf_line/smf_line.h"

namespace firn::gains {

using control::smf_line::Gains;

enum class Algorithm {
  kSlsqp,   ///< sequential quadratic programming, gradient and constraints (5.25)
  kLbfgs,   ///< quasi-Newton, gradient and bounds
  kCobyla,  ///< linear approximations, constraints (5.25), no gradient
};
std::string_view name(Algorithm algorithm);

struct TuneOptions {
  Algorithm algorithm = Algorithm::kSlsqp;
  Gains start{1.0, 1.0, 0.0};
  bool derivative_only = false;  ///< (5.39): K_p and K_i* stay at their start
  int max_evaluations = 2000;    ///< of the objective
};

struct TunedGains {
  Gains gains;
  double rms = 0.0;         ///< sigma_p* of (5.27), in intervals
  double optimality = 0.0;  ///< largest entry of the gradient, less the bounds' multipliers (5.36), (5.37)
  int evaluations = 0;
};

/// Searches 0 <= K_p <= 2, 0 <= K_i* <= 4, 0 <= K_d* <= 1 (the box around (5.25)) from options.start, which
/// is moved into it. Deterministic: stops by tolerance or max_evaluations, never by time.
/// @throws std::invalid_argument: an empty disturbance or one with a number that is not finite;
/// max_evaluations below 1
TunedGains tune_smf(std::span<const double> disturbance, const TuneOptions& options);

}  // namespace firn::gains
