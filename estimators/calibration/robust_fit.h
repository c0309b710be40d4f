// Least squares with Huber's loss by NLopt, standard deviations and 95 % intervals, and the refusal of data
// that cannot tell.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn::calibration {

/// Thrown for data that do not determine what is asked for; names it.
struct Uninformative : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A number with its standard deviation and the half width of its 95 % interval.
struct Estimate {
  double value = 0.0, std = 0.0, half_95 = 0.0;
};

struct Unknown {
  std::string name;  ///< "laser offset x", for messages
  double start = 0.0;
  double scale = 1.0;  ///< a change of it that matters
  double reach = 0.0;  ///< looked for within start +- reach
};

/// What is known of the data's scatter beforehand. kEach: each datum's may be its own, so that a variance is
/// what the residuals make of it where they weigh (HC2, Student's degrees of freedom by Bell and McCaffrey
/// [2002]); it takes more data for the same confidence.
enum class Scatter { kAlike, kEach };

struct FitResult {
  std::vector<Estimate> unknowns;
  double residual_std = 0.0;   ///< of one datum about the fit, robust
  int data = 0, outliers = 0;  ///< beyond 4 standard deviations
  long evaluations = 0;
  Scatter scatter = Scatter::kAlike;
  std::vector<std::vector<double>> inverse, rows;  ///< (J^T J)^-1 and J of the data that count
  std::vector<double> residuals;                   ///< of these
  std::vector<std::size_t> used;                   ///< which these are
  double least_std = 0.0;
  /// A quantity with these derivatives by the unknowns.
  Estimate estimate(double value, const std::vector<double>& by_unknown) const;
};

/// Residual of datum i at x, with its derivatives by the unknowns into `gradient`. In any unit, the same for
/// all.
using Residual = std::function<double(std::size_t i, const double* x, double* gradient)>;

/// Minimises sum rho(r_i / sigma) by L-BFGS with at most 1000 evaluations, in the axes of the information
/// matrix (a badly conditioned problem would not converge in its own), sigma from the residuals' median
/// deviation: three rounds with Huber's rho at 3, and from there one in which what lies beyond 4 sigma pulls
/// no more: rejecting nearer would make the intervals of few good data too narrow. Intervals are Student's:
/// with scatter alike sigma^2 (J^T J)^-1 and the data's degrees of freedom.
/// @param least_std what sigma may not fall below (resolution of the instrument)
/// @throws Uninformative: fewer data than unknowns + 2; an unknown that others can make up for to 1e-4
/// (named); an unknown at the end of its reach
FitResult robust_fit(const std::vector<Unknown>& unknowns, std::size_t data, const Residual& residual,
                     double least_std, Scatter scatter = Scatter::kAlike);

/// The factor t with P(|T| < t) = 0.95 for `freedom` >= 1.
double student_95(double freedom);

}  // namespace firn::calibration
