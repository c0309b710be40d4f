#include "estimators/lab/synthetic_likelihood.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace firn::lab {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using View = Eigen::Map<const RowMajor>;

constexpr double kFitRidge = 1e-3;  // of the parameters' unit variance
constexpr double kMinStd = 1e-9;
constexpr double kUnmoved = 1e-7;   // standard deviation below which no simulation moves a feature
constexpr double kSame = 1e-6;      // relative difference of values that are equal but for rounding
constexpr double kRounding = 1e-6;  // variance of scaled features beyond the simulated one
constexpr std::size_t kSpareRows = 5;

Matrix covariance_of(const Normal& n) {
  const auto size = Eigen::Index(n.mean.size());
  return View(n.covariance.data(), size, size);
}

Matrix columns(const Matrix& from, std::span<const std::size_t> used) {
  Matrix out(from.rows(), Eigen::Index(used.size()));
  for (std::size_t n = 0; n < used.size(); ++n) out.col(Eigen::Index(n)) = from.col(Eigen::Index(used[n]));
  return out;
}

// Covariance of the residuals' columns, shrunk towards its diagonal.
Matrix shrunk_covariance(const Matrix& residual, double freedom) {
  Matrix s = residual.transpose() * residual / freedom;
  const Vector diagonal = s.diagonal().cwiseMax(kMinStd * kMinStd);
  s *= 1.0 - kShrink;
  s.diagonal() = diagonal;
  return s;
}

}  // namespace

void Simulations::add(std::span<const double> z_row, std::span<const double> s_row) {
  if (z_row.size() != parameters || s_row.size() != features)
    throw std::invalid_argument("simulations: a row of another length");
  const auto finite = [](double v) { return std::isfinite(v); };
  if (!std::ranges::all_of(z_row, finite) || !std::ranges::all_of(s_row, finite))
    throw std::invalid_argument("simulations: a value that is not finite");
  z.insert(z.end(), z_row.begin(), z_row.end());
  s.insert(s.end(), s_row.begin(), s_row.end());
}

double Normal::std(std::size_t p) const { return std::sqrt(covariance[p * mean.size() + p]); }

std::vector<double> Normal::at(std::span<const double> normals, double widen) const {
  const Matrix lower = covariance_of(*this).llt().matrixL();
  const Vector x = Vector::Map(mean.data(), Eigen::Index(mean.size())) +
                   widen * lower * Vector::Map(normals.data(), Eigen::Index(normals.size()));
  return {x.begin(), x.end()};
}

std::vector<double> Normal::normals_of(std::span<const double> point) const {
  const Matrix lower = covariance_of(*this).llt().matrixL();
  const auto size = Eigen::Index(mean.size());
  const Vector x = lower.triangularView<Eigen::Lower>().solve(Vector::Map(point.data(), size) -
                                                              Vector::Map(mean.data(), size));
  return {x.begin(), x.end()};
}

double Normal::log_determinant() const {
  return 2.0 * Matrix(covariance_of(*this).llt().matrixL()).diagonal().array().log().sum();
}

double Normal::std_with(const Normal& normals, std::size_t p) const {
  const Matrix lower = covariance_of(*this).llt().matrixL();
  const Vector row = lower.row(Eigen::Index(p)).transpose();
  return std::sqrt(row.dot(covariance_of(normals) * row));
}

Normal standard_normal(std::size_t parameters) {
  Normal n{std::vector<double>(parameters, 0.0), std::vector<double>(parameters * parameters, 0.0)};
  for (std::size_t p = 0; p < parameters; ++p) n.covariance[p * parameters + p] = 1.0;
  return n;
}

SyntheticLikelihood::SyntheticLikelihood(const Simulations& sims)
    : rows_(sims.rows()), parameters_(sims.parameters), features_(sims.features) {
  if (rows_ < parameters_ + kSpareRows)
    throw std::invalid_argument(std::to_string(rows_) + " simulations are too few for " +
                                std::to_string(parameters_) + " parameters");
  const auto rows = Eigen::Index(rows_), wide = Eigen::Index(parameters_), tall = Eigen::Index(features_);
  const View z(sims.z.data(), rows, wide);
  const View s(sims.s.data(), rows, tall);
  const Eigen::RowVectorXd z_mean = z.colwise().mean(), s_mean = s.colwise().mean();
  const Matrix zc = z.rowwise() - z_mean, sc = s.rowwise() - s_mean;
  Matrix normal = zc.transpose() * zc;
  normal.diagonal().array() += kFitRidge * double(rows_);
  const Eigen::LLT<Matrix> solver(normal);
  const Matrix slope = solver.solve(zc.transpose() * sc);  // parameters x features
  const Eigen::RowVectorXd intercept = s_mean - z_mean * slope;
  const RowMajor residual = sc - zc * slope;
  const double freedom = double(rows_ - parameters_ - 1);
  intercept_.assign(intercept.begin(), intercept.end());
  const RowMajor by_feature = slope.transpose();
  slope_.assign(by_feature.data(), by_feature.data() + by_feature.size());
  residual_.assign(residual.data(), residual.data() + residual.size());
  for (Eigen::Index n = 0; n < rows; ++n)
    leverage_.push_back(1.0 / double(rows_) + zc.row(n).dot(solver.solve(zc.row(n).transpose())));
  for (Eigen::Index f = 0; f < tall; ++f)
    std_.push_back(std::max(kMinStd, std::sqrt(residual.col(f).squaredNorm() / freedom)));
}

bool SyntheticLikelihood::moved(std::size_t feature) const { return std_[feature] >= kUnmoved; }

Normal SyntheticLikelihood::posterior(std::span<const double> observed, std::span<const std::size_t> used,
                                      double prior_std) const {
  const auto wide = Eigen::Index(parameters_);
  const View residual(residual_.data(), Eigen::Index(rows_), Eigen::Index(features_));
  const View slope(slope_.data(), Eigen::Index(features_), wide);
  // In units of each feature's own scatter, so that the factorisation is well conditioned.
  Matrix e = columns(residual, used), b(Eigen::Index(used.size()), wide);
  Vector d(Eigen::Index(used.size()));
  for (std::size_t n = 0; n < used.size(); ++n) {
    const auto row = Eigen::Index(n);
    const std::size_t f = used[n];
    e.col(row) /= std_[f];
    b.row(row) = slope.row(Eigen::Index(f)) / std_[f];
    d[row] = (observed[f] - intercept_[f]) / std_[f];
  }
  const Eigen::LLT<Matrix> noise(shrunk_covariance(e, double(rows_ - parameters_ - 1)));
  const Matrix information =
      b.transpose() * noise.solve(b) + Matrix::Identity(wide, wide) / (prior_std * prior_std);
  const Eigen::LLT<Matrix> solver(information);
  const Vector mean = solver.solve(b.transpose() * noise.solve(d));
  const RowMajor covariance = solver.solve(Matrix::Identity(wide, wide));
  return {{mean.begin(), mean.end()}, {covariance.data(), covariance.data() + covariance.size()}};
}

double SyntheticLikelihood::log_predictive(std::span<const double> observed,
                                           std::span<const std::size_t> used,
                                           const Normal& parameters) const {
  const auto wide = Eigen::Index(parameters_), tall = Eigen::Index(used.size());
  const View residual(residual_.data(), Eigen::Index(rows_), Eigen::Index(features_));
  const View slope(slope_.data(), Eigen::Index(features_), wide);
  const Vector m = Vector::Map(parameters.mean.data(), wide);
  Matrix b(tall, wide);
  Vector d(tall);
  for (std::size_t n = 0; n < used.size(); ++n) {
    const auto f = Eigen::Index(used[n]);
    b.row(Eigen::Index(n)) = slope.row(f);
    d[Eigen::Index(n)] = observed[used[n]] - intercept_[used[n]] - slope.row(f).dot(m);
  }
  const Matrix s = shrunk_covariance(columns(residual, used), double(rows_ - parameters_ - 1)) +
                   b * covariance_of(parameters) * b.transpose();
  const Eigen::LLT<Matrix> factor(s);
  const double log_det = 2.0 * Matrix(factor.matrixL()).diagonal().array().log().sum();
  return -0.5 * (d.dot(factor.solve(d)) + log_det + double(tall) * std::log(2.0 * std::numbers::pi));
}

std::vector<double> SyntheticLikelihood::deviations(std::span<const double> observed,
                                                    const Normal& parameters) const {
  const auto wide = Eigen::Index(parameters_);
  const Matrix c = covariance_of(parameters);
  const Vector m = Vector::Map(parameters.mean.data(), wide);
  std::vector<double> out;
  for (std::size_t f = 0; f < features_; ++f) {
    const Vector b = Vector::Map(slope_.data() + f * parameters_, wide);
    const double off = observed[f] - intercept_[f] - b.dot(m);
    const bool same = !moved(f) && std::abs(off) <= kSame * (1.0 + std::abs(observed[f]));
    out.push_back(same ? 0.0 : off / std::sqrt(std_[f] * std_[f] + b.dot(c * b)));
  }
  return out;
}

std::vector<double> SyntheticLikelihood::largest_deviations(std::span<const std::size_t> used) const {
  std::vector<double> out(rows_, 0.0);
  for (std::size_t n = 0; n < rows_; ++n)
    for (const std::size_t f : used)
      out[n] = std::max(out[n], std::abs(residual_[n * features_ + f]) / std_[f]);
  return out;
}

double SyntheticLikelihood::joint_deviation(std::span<const double> observed,
                                            std::span<const std::size_t> used,
                                            const Normal& parameters) const {
  if (used.empty()) throw std::invalid_argument("joint deviation of no feature");
  const auto wide = Eigen::Index(parameters_), tall = Eigen::Index(used.size());
  Matrix e(Eigen::Index(rows_), tall), b(tall, wide);
  Vector d(tall);
  for (std::size_t n = 0; n < used.size(); ++n) {
    const auto at = Eigen::Index(n);
    const std::size_t f = used[n];
    for (std::size_t row = 0; row < rows_; ++row)
      e(Eigen::Index(row), at) = residual_[row * features_ + f] / std_[f];
    b.row(at) = Vector::Map(slope_.data() + f * parameters_, wide).transpose() / std_[f];
    d[at] = moved(f) ? (observed[f] - intercept_[f]) / std_[f] : 0.0;
    if (!moved(f)) b.row(at).setZero();
  }
  d -= b * Vector::Map(parameters.mean.data(), wide);
  Matrix v =
      shrunk_covariance(e, double(rows_ - parameters_ - 1)) + b * covariance_of(parameters) * b.transpose();
  v.diagonal().array() += kRounding;
  return d.dot(v.llt().solve(d)) / double(tall);
}

std::vector<double> SyntheticLikelihood::joint_deviations(std::span<const std::size_t> used) const {
  if (used.empty()) throw std::invalid_argument("joint deviations of no feature");
  const auto tall = Eigen::Index(used.size());
  Matrix e(Eigen::Index(rows_), tall);
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t n = 0; n < used.size(); ++n)
      e(Eigen::Index(row), Eigen::Index(n)) = residual_[row * features_ + used[n]] / std_[used[n]];
  const double freedom = double(rows_ - parameters_ - 2);
  std::vector<double> out;
  for (Eigen::Index row = 0; row < e.rows(); ++row) {
    Matrix others = e;
    others.row(row).setZero();
    const Vector d = e.row(row).transpose() / (1.0 - leverage_[std::size_t(row)]);
    Matrix v = shrunk_covariance(others, freedom);
    v.diagonal().array() += kRounding;
    out.push_back(d.dot(v.llt().solve(d)) / double(tall));
  }
  return out;
}

}  // namespace firn::lab
