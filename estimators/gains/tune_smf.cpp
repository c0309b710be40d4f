#include "estimators/gains/tune_smf.h"

#include <nlopt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace firn::gains {
namespace {

constexpr std::array<double, 3> kHigh{2.0, 4.0, 1.0};  // where the plane of (5.25) meets the axes
constexpr double kTolerance = 1e-9;  // of the gains; the optimum is flat: sigma moves by its square

Gains gains_of(const double* x) { return {x[0], x[1], x[2]}; }

struct Problem {
  std::span<const double> d;
  Gains fixed;
  bool derivative_only;
  int evaluations = 0;

  Gains at(const double* x) const {
    return derivative_only ? Gains{fixed.kp, fixed.ki_star, x[0]} : gains_of(x);
  }
};

// An unstable loop may overflow: a large finite value turns every search back.
double objective(unsigned n, const double* x, double* gradient, void* data) {
  Problem& p = *static_cast<Problem*>(data);
  ++p.evaluations;
  const auto s = control::smf_line::spread(p.at(x), p.d);
  const bool finite = std::isfinite(s.rms) && std::isfinite(s.gradient[0] + s.gradient[1] + s.gradient[2]);
  if (gradient)
    for (unsigned i = 0; i < n; ++i) gradient[i] = finite ? s.gradient[p.derivative_only ? 2 : i] : 1.0;
  return finite ? s.rms : 1e100;
}

// K_p/2 + K_i*/4 + K_d* - 1 <= 0, the plane of (5.25).
double plane(unsigned n, const double* x, double* gradient, void* data) {
  const Problem& p = *static_cast<const Problem*>(data);
  if (gradient) {
    constexpr std::array<double, 3> kNormal{0.5, 0.25, 1.0};
    for (unsigned i = 0; i < n; ++i) gradient[i] = p.derivative_only ? 1.0 : kNormal[i];
  }
  const Gains g = p.at(x);
  return 0.5 * g.kp + 0.25 * g.ki_star + g.kd_star - 1.0;
}

// The part of the gradient that no bound holds back.
double optimality(const Problem& p, const Gains& g) {
  const auto s = control::smf_line::spread(g, p.d);
  const std::array<double, 3> x{g.kp, g.ki_star, g.kd_star};
  double worst = 0.0;
  for (std::size_t i = p.derivative_only ? 2 : 0; i < 3; ++i) {
    const bool held = (x[i] <= 0.0 && s.gradient[i] > 0.0) || (x[i] >= kHigh[i] && s.gradient[i] < 0.0);
    if (!held) worst = std::max(worst, std::abs(s.gradient[i]));
  }
  return worst;
}

nlopt_algorithm code(Algorithm a) {
  switch (a) {
    case Algorithm::kLbfgs:
      return NLOPT_LD_LBFGS;
    case Algorithm::kCobyla:
      return NLOPT_LN_COBYLA;
    default:
      return NLOPT_LD_SLSQP;
  }
}

}  // namespace

std::string_view name(Algorithm a) {
  switch (a) {
    case Algorithm::kLbfgs:
      return "L-BFGS";
    case Algorithm::kCobyla:
      return "COBYLA";
    default:
      return "SLSQP";
  }
}

TunedGains tune_smf(std::span<const double> d, const TuneOptions& o) {
  if (d.empty() || !std::all_of(d.begin(), d.end(), [](double v) { return std::isfinite(v); }))
    throw std::invalid_argument("the disturbance is empty or not finite");
  if (o.max_evaluations < 1)
    throw std::invalid_argument("max_evaluations = " + std::to_string(o.max_evaluations) + " is below 1");
  Problem problem{d, o.start, o.derivative_only};
  const unsigned n = o.derivative_only ? 1 : 3;
  std::array<double, 3> x{o.start.kp, o.start.ki_star, o.start.kd_star}, high = kHigh;
  const std::array<double, 3> low{};
  if (o.derivative_only) {
    x[0] = x[2];
    high[0] = high[2];
  }
  for (unsigned i = 0; i < n; ++i) x[i] = std::clamp(x[i], low[i], high[i]);

  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(code(o.algorithm), n),
                                                              nlopt_destroy);
  nlopt_set_lower_bounds(opt.get(), low.data());
  nlopt_set_upper_bounds(opt.get(), high.data());
  nlopt_set_min_objective(opt.get(), objective, &problem);
  if (o.algorithm != Algorithm::kLbfgs) nlopt_add_inequality_constraint(opt.get(), plane, &problem, 1e-12);
  if (o.algorithm == Algorithm::kCobyla) nlopt_set_initial_step1(opt.get(), 0.1);
  nlopt_set_xtol_abs1(opt.get(), kTolerance);
  nlopt_set_maxeval(opt.get(), o.max_evaluations);
  double value = 0.0;
  nlopt_optimize(opt.get(), x.data(), &value);  // a failure (round-off reached) leaves the best point in x

  TunedGains tuned;
  tuned.gains = problem.at(x.data());
  tuned.rms = control::smf_line::spread(tuned.gains, d).rms;
  tuned.optimality = optimality(problem, tuned.gains);
  tuned.evaluations = problem.evaluations;
  return tuned;
}

}  // namespace firn::gains
