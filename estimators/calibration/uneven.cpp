#include "estimators/calibration/uneven.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace firn::calibration {
namespace {

constexpr int kLengths = 6;
constexpr double kNugget = 1e-9;  // keeps a correlation of near places positive definite

using Matrix = std::vector<std::vector<double>>;

/// Lower L of m = L L^T, in place. @returns log |m| / 2
double cholesky(Matrix& m) {
  double log_det = 0.0;
  for (std::size_t a = 0; a < m.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = m[a][b];
      for (std::size_t k = 0; k < b; ++k) sum -= m[a][k] * m[b][k];
      m[a][b] = a == b ? std::sqrt(sum) : sum / m[b][b];
      if (a == b) log_det += std::log(m[a][a]);
    }
  return log_det;
}

/// L^-1 v in place.
void forward(const Matrix& lower, std::vector<double>& v) {
  for (std::size_t a = 0; a < v.size(); ++a) {
    for (std::size_t k = 0; k < a; ++k) v[a] -= lower[a][k] * v[k];
    v[a] /= lower[a][a];
  }
}

/// L^-T v in place.
void backward(const Matrix& lower, std::vector<double>& v) {
  for (std::size_t a = v.size(); a-- > 0;) {
    for (std::size_t k = a + 1; k < v.size(); ++k) v[a] -= lower[k][a] * v[k];
    v[a] /= lower[a][a];
  }
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

double distance(const UnevenDatum& a, const UnevenDatum& b) { return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm); }

struct AtLength {
  std::vector<double> value, variance;
  double log_restricted = 0.0, log_profile = 0.0;
};

AtLength fit_at(const std::vector<UnevenDatum>& data, std::size_t unknowns, double length_mm, double least_mm) {
  const std::size_t n = data.size();
  Matrix lower(n, std::vector<double>(n, 0.0));
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const double share = length_mm > 0.0 ? distance(data[a], data[b]) / length_mm : std::numeric_limits<double>::infinity();
      lower[a][b] = a == b ? 1.0 + kNugget : std::exp(-share * share);
    }
  const double log_correlation = cholesky(lower);
  std::vector<double> z, size(unknowns, 0.0);
  for (const UnevenDatum& d : data) z.push_back(d.z_mm);
  forward(lower, z);
  Matrix columns(unknowns, std::vector<double>(n)), normal(unknowns, std::vector<double>(unknowns));
  for (std::size_t k = 0; k < unknowns; ++k) {  // of size 1, whatever their units
    for (std::size_t i = 0; i < n; ++i) size[k] = std::max(size[k], std::abs(data[i].row[k]));
    for (std::size_t i = 0; i < n; ++i) columns[k][i] = data[i].row[k] / size[k];
    forward(lower, columns[k]);
  }
  AtLength f;
  for (std::size_t a = 0; a < unknowns; ++a) {
    for (std::size_t b = 0; b < unknowns; ++b) normal[a][b] = dot(columns[a], columns[b]);
    f.value.push_back(dot(columns[a], z));
  }
  const double log_normal = cholesky(normal);
  forward(normal, f.value);
  backward(normal, f.value);
  double squares = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    double off = z[i];
    for (std::size_t k = 0; k < unknowns; ++k) off -= columns[k][i] * f.value[k];
    squares += off * off;
  }
  squares = std::max(squares, double(n) * least_mm * least_mm);
  const double freedom = double(n - unknowns);
  for (std::size_t k = 0; k < unknowns; ++k) {
    std::vector<double> itself(unknowns, 0.0);
    itself[k] = 1.0;
    forward(normal, itself);
    f.variance.push_back(squares / freedom * dot(itself, itself) / (size[k] * size[k]));
    f.value[k] /= size[k];
  }
  f.log_profile = -log_correlation - 0.5 * double(n) * std::log(squares);
  f.log_restricted = -log_correlation - log_normal - 0.5 * freedom * std::log(squares);
  return f;
}

}  // namespace

UnevenFit fit_uneven(const std::vector<UnevenDatum>& data, std::size_t unknowns, double least_mm) {
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
    fits.push_back(fit_at(data, unknowns, apart_mm * k / (kLengths - 1), least_mm));
    likeliest = std::max(likeliest, fits.back().log_restricted), profile = std::max(profile, fits.back().log_profile);
  }
  for (const AtLength& f : fits) sum += std::exp(f.log_restricted - likeliest), mean += std::exp(f.log_profile - profile) / kLengths;
  UnevenFit out{std::vector<double>(unknowns, 0.0), std::vector<double>(unknowns, 0.0), double(data.size() - unknowns),
                profile + std::log(mean) - 0.5 * double(unknowns) * std::log(double(data.size()))};
  const auto share = [&](const AtLength& f) { return std::exp(f.log_restricted - likeliest) / sum; };
  for (std::size_t k = 0; k < unknowns; ++k) {
    for (const AtLength& f : fits) out.value[k] += share(f) * f.value[k];
    for (const AtLength& f : fits) out.variance[k] += share(f) * (f.variance[k] + (f.value[k] - out.value[k]) * (f.value[k] - out.value[k]));
  }
  return out;
}

}  // namespace firn::calibration
