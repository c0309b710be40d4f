#include "estimators/lab/box_search.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

namespace firn::lab {
namespace {

constexpr double kLargest = 1e100;    // NLopt takes no infinity
constexpr double kFirstStep = 0.08;   // of the local search, in shares of the box
constexpr double kTolerance = 0.004;  // of the local search's points

struct Search {
  const std::function<double(std::span<const double>)>* function;
  std::vector<BoxPoint> points;
  std::exception_ptr failure;
  nlopt_opt running = nullptr;
};

double evaluate(unsigned n, const double* u, double*, void* data) {
  Search& search = *static_cast<Search*>(data);
  if (search.failure) return kLargest;
  try {
    const double value = (*search.function)({u, n});
    const double held = std::isfinite(value) ? std::min(value, kLargest) : kLargest;
    search.points.push_back({{u, u + n}, held});
    return held;
  } catch (...) {  // C code lies between here and the caller
    search.failure = std::current_exception();
    nlopt_force_stop(search.running);
    return kLargest;
  }
}

void run(Search& search, nlopt_algorithm algorithm, std::vector<double> start, int evaluations) {
  if (evaluations <= 0 || search.failure) return;
  const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(algorithm, unsigned(start.size())),
                                                              nlopt_destroy);
  search.running = opt.get();
  nlopt_set_lower_bounds1(opt.get(), 0.0);
  nlopt_set_upper_bounds1(opt.get(), 1.0);
  nlopt_set_min_objective(opt.get(), evaluate, &search);
  nlopt_set_maxeval(opt.get(), evaluations);
  nlopt_set_initial_step1(opt.get(), kFirstStep);
  nlopt_set_xtol_abs1(opt.get(), kTolerance);
  double value = 0.0;
  nlopt_optimize(opt.get(), start.data(), &value);
}

}  // namespace

std::vector<BoxPoint> minimise_in_box(const std::function<double(std::span<const double>)>& function,
                                      std::span<const double> start, int evaluations) {
  Search search{&function, {}, nullptr, nullptr};
  search.points.push_back({{start.begin(), start.end()}, function(start)});
  if (start.empty()) return std::move(search.points);
  const int left = evaluations - 1, local = left / 3;
  run(search, NLOPT_GN_DIRECT_L, search.points.front().u, left - local);
  const auto best = std::ranges::min_element(search.points, {}, &BoxPoint::value);
  run(search, NLOPT_LN_NELDERMEAD, best->u, local);
  if (search.failure) std::rethrow_exception(search.failure);
  return std::move(search.points);
}

}  // namespace firn::lab
