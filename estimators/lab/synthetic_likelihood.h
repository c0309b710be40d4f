// SyntheticLikelihood computes the posterior of a simulator's parameters from features of simulated and of
// observed data: near the posterior the features are Gaussian with a mean that is linear in the parameters
// [Wood 2010, Nature 466, "Statistical inference for noisy nonlinear ecological dynamic systems"; the linear
// mean as in Beaumont 2002, Genetics 162]. The features may depend on the simulator's own feedback in any
// way, since the simulated ones depend on it in the same way (indirect inference): a feature need not be an
// unbiased estimate of anything.
//
// With z the parameters, standard normal a priori, and s the features:
//   s = a + B z + e,  e ~ N(0, S)          by least squares with a small ridge over the simulations
//   C = (I + B' S^-1 B)^-1,  m = C B' S^-1 (s_observed - a)
// S is shrunk towards its diagonal, because there are not many more simulations than features.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace firn::lab {

/// Simulated rows: parameters z, and features s of the simulation with these parameters.
struct Simulations {
  std::size_t parameters = 0, features = 0;
  std::vector<double> z;  ///< [row * parameters + p]
  std::vector<double> s;  ///< [row * features + f]

  std::size_t rows() const { return parameters == 0 ? 0 : z.size() / parameters; }
  /// Adds one row. @throws std::invalid_argument: another length, a value that is not finite
  void add(std::span<const double> z_row, std::span<const double> s_row);
  void clear() {
    z.clear();
    s.clear();
  }
};

/// A normal distribution of the parameters.
struct Normal {
  std::vector<double> mean;
  std::vector<double> covariance;  ///< [p * size + q]
  double std(std::size_t p) const;
  /// Returns the point mean + widen L normals, L the Cholesky factor of the covariance.
  std::vector<double> at(std::span<const double> normals, double widen = 1.0) const;
  /// Returns the normals with which at() returns `point`.
  std::vector<double> normals_of(std::span<const double> point) const;
  double log_determinant() const;  ///< of the covariance
  /// Returns the standard deviation of p where the normals of at() are distributed as `normals` are.
  double std_with(const Normal& normals, std::size_t p) const;
};
/// Returns N(0, I).
Normal standard_normal(std::size_t parameters);

/// The weight of the diagonal in S.
inline constexpr double kShrink = 0.3;

class SyntheticLikelihood {
 public:
  /// @throws std::invalid_argument: fewer rows than parameters + 5
  explicit SyntheticLikelihood(const Simulations& simulations);

  /// Returns the posterior from the features with these indices.
  /// @param observed of all features, finite
  /// @param prior_std of each parameter before: beyond 1 where the prior is doubted
  Normal posterior(std::span<const double> observed, std::span<const std::size_t> used,
                   double prior_std = 1.0) const;

  /// Returns the log density of the features with these indices, predicted with the parameters' distribution.
  double log_predictive(std::span<const double> observed, std::span<const std::size_t> used,
                        const Normal& parameters) const;

  /// Returns whether the simulations differ in this feature by more than rounding.
  bool moved(std::size_t feature) const;

  /// Returns (observed - predicted) / standard deviation of each feature. One that no simulation moves
  /// deviates by 0 where the observed value is the simulated one but for rounding, else beyond any limit.
  std::vector<double> deviations(std::span<const double> observed, const Normal& parameters) const;

  /// Returns the largest |deviation| over the features with these indices, of each simulation from its own
  /// prediction.
  std::vector<double> largest_deviations(std::span<const std::size_t> used) const;

  /// Returns d' V^-1 d / n, d = observed - predicted of the n features with these indices, V their
  /// covariance.
  /// @throws std::invalid_argument: none is given
  double joint_deviation(std::span<const double> observed, std::span<const std::size_t> used,
                         const Normal& parameters) const;

  /// Returns the same of each simulation from the prediction and covariance of the others.
  std::vector<double> joint_deviations(std::span<const std::size_t> used) const;

 private:
  std::size_t rows_, parameters_, features_;
  std::vector<double> intercept_;  ///< a
  std::vector<double> slope_;      ///< B, [f * parameters + p]
  std::vector<double> residual_;   ///< e, [row * features + f]
  std::vector<double> std_;        ///< of e
  std::vector<double> leverage_;   ///< of each row in the regression
};

}  // namespace firn::lab
