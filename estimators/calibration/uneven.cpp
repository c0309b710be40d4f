#include "estimators/calibration/uneven.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::calibration {
namespace {

constexpr int kLengths = 6;
constexpr double kNugget = 1e-9;  // keeps a correlation of near places positive definite

/// log |m| / 2
double half_log_det(const Eigen::LLT<Eigen::MatrixXd>& m) {
  return m.matrixLLT().diagonal().array().log().sum();
}

double distance(const UnevenDatum& a, const UnevenDatum& b) {
  return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm);
}

struct AtLength {
  Eigen::VectorXd value, variance;
  double log_restricted = 0.0, log_profile = 0.0;
};

AtLength fit_at(const std::vector<UnevenDatum>& data, Eigen::Index parameters, double length_mm,
                double min_mm) {
  const Eigen::Index n = Eigen::Index(data.size());
  Eigen::MatrixXd correlation(n, n), columns(n, parameters);
  Eigen::VectorXd z(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const UnevenDatum& d = data[a];
    z[a] = d.z_mm;
    for (Eigen::Index k = 0; k < parameters; ++k) columns(a, k) = d.row[k];
    for (Eigen::Index b = 0; b < n; ++b) {
      const double share =
          length_mm > 0.0 ? distance(d, data[b]) / length_mm : std::numeric_limits<double>::infinity();
      correlation(a, b) = a == b ? 1.0 + kNugget : std::exp(-share * share);
    }
  }
  const Eigen::ArrayXd size = columns.cwiseAbs().colwise().maxCoeff().transpose();
  columns *= size.inverse().matrix().asDiagonal();  // of size 1, for any units
  const Eigen::LLT<Eigen::MatrixXd> correlated(correlation);
  correlated.matrixL().solveInPlace(z);
  correlated.matrixL().solveInPlace(columns);
  const Eigen::LLT<Eigen::MatrixXd> normal(columns.transpose() * columns);
  const Eigen::VectorXd value = normal.solve(columns.transpose() * z);
  const double squares = std::max((z - columns * value).squaredNorm(), double(n) * min_mm * min_mm);
  const double freedom = double(n - parameters), log_correlation = half_log_det(correlated);
  const Eigen::ArrayXd inverse = normal.solve(Eigen::MatrixXd::Identity(parameters, parameters)).diagonal();
  AtLength f;
  f.value = value.array() / size;
  f.variance = squares / freedom * inverse / size.square();
  f.log_profile = -log_correlation - 0.5 * double(n) * std::log(squares);
  f.log_restricted = -log_correlation - half_log_det(normal) - 0.5 * freedom * std::log(squares);
  return f;
}

}  // namespace

UnevenFit fit_uneven(const std::vector<UnevenDatum>& data, std::size_t parameters, double min_mm) {
  double apart_mm = 0.0;
  for (const UnevenDatum& a : data) {
    double nearest = std::numeric_limits<double>::max();
    for (const UnevenDatum& b : data)
      if (&a != &b) nearest = std::min(nearest, distance(a, b));
    apart_mm += nearest / double(data.size());
  }
  std::vector<AtLength> fits;
  double likeliest = -std::numeric_limits<double>::infinity(), profile = likeliest, sum = 0.0, mean = 0.0;
  for (int k = 0; k < kLengths; ++k) {
    fits.push_back(fit_at(data, Eigen::Index(parameters), apart_mm * k / (kLengths - 1), min_mm));
    likeliest = std::max(likeliest, fits.back().log_restricted);
    profile = std::max(profile, fits.back().log_profile);
  }
  for (const AtLength& f : fits) {
    sum += std::exp(f.log_restricted - likeliest);
    mean += std::exp(f.log_profile - profile) / kLengths;
  }
  UnevenFit out{std::vector<double>(parameters, 0.0), std::vector<double>(parameters, 0.0),
                double(data.size() - parameters),
                profile + std::log(mean) - 0.5 * double(parameters) * std::log(double(data.size()))};
  const auto share = [&](const AtLength& f) { return std::exp(f.log_restricted - likeliest) / sum; };
  for (std::size_t k = 0; k < parameters; ++k) {
    for (const AtLength& f : fits) out.value[k] += share(f) * f.value[k];
    for (const AtLength& f : fits)
      out.variance[k] +=
          share(f) * (f.variance[k] + (f.value[k] - out.value[k]) * (f.value[k] - out.value[k]));
  }
  return out;
}

}  // namespace firn::calibration
