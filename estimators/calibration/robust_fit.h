// robust_fit() estimates parameters by least squares with Huber's loss, with standard deviations and 95 %
// intervals. Data that do not identify the parameters are refused.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn::calibration {

/// Thrown for data that do not identify a parameter; names the parameter.
struct Unidentifiable : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A number with its standard deviation and the half width of its 95 % interval.
struct Estimate {
  double value = 0.0, std = 0.0, ci95_half_width = 0.0;
};

struct Parameter {
  std::string name;  ///< "laser offset x", for messages
  double start = 0.0;
  double scale = 1.0;  ///< a relevant change
  double bound = 0.0;  ///< searched within start +- bound
};

/// Prior knowledge of the data's variance. kHomoscedastic: equal for all data. kHeteroscedastic: each datum
/// may have its own, so that variances come from the weighted residuals (HC2, Student's degrees of freedom by
/// Bell and McCaffrey [2002]); this requires more data for the same confidence.
enum class Scatter { kHomoscedastic, kHeteroscedastic };

struct FitResult {
  std::vector<Estimate> parameters;
  double residual_std = 0.0;   ///< of one datum about the fit, robust
  int data = 0, outliers = 0;  ///< beyond 4 standard deviations
  long evaluations = 0;
  Scatter scatter = Scatter::kHomoscedastic;
  std::vector<std::vector<double>> inverse, rows;  ///< (J^T J)^-1 and J of the data that count
  std::vector<double> residuals;                   ///< of these
  std::vector<std::size_t> used;                   ///< which these are
  double min_std = 0.0;
  /// A quantity with these derivatives by the parameters.
  Estimate estimate(double value, const std::vector<double>& by_parameter) const;
};

/// Residual of datum i at x, with its derivatives by the parameters into `gradient`. In any unit, the same
/// for all.
using Residual = std::function<double(std::size_t i, const double* x, double* gradient)>;

/// Minimises sum rho(r_i / sigma) by L-BFGS with at most 1000 evaluations, in the axes of the information
/// matrix (a badly conditioned problem would not converge in its own), sigma from the residuals' median
/// deviation: three rounds with Huber's rho at 3, and from there one in which residuals beyond 4 sigma have
/// no influence: a smaller threshold would make the intervals of few good data too narrow. Intervals are
/// Student's: for homoscedastic data sigma^2 (J^T J)^-1 and the data's degrees of freedom.
/// @param min_std minimum of sigma (resolution of the instrument)
/// @throws Unidentifiable: fewer data than parameters + 2; a parameter that others can replace to 1e-4
/// (named); a parameter at its bound
FitResult robust_fit(const std::vector<Parameter>& parameters, std::size_t data, const Residual& residual,
                     double min_std, Scatter scatter = Scatter::kHomoscedastic);

}  // namespace firn::calibration
