#include "estimators/calibration/robust_fit.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace firn::calibration {
namespace {

constexpr double kClip = 3.0, kReject = 4.0, kMadToStd = 1.4826, kConfounded = 1e-4, kBlind = 1e-10;
constexpr int kRounds = 4, kMostEvaluations = 1000;

using Matrix = std::vector<std::vector<double>>;

struct Problem {
  const std::vector<Unknown>& unknowns;
  std::size_t data;
  const Residual& residual;
  double sigma = 1.0;
  bool reject = false;   ///< what lies beyond the clip pulls no more
  long evaluations = 0;
  std::vector<double> x, row;      // of the caller's unknowns
  std::vector<double> base, slope; // (x - start) / scale where the round began; the gradient by it
  Matrix axes;                     // NLopt's y: (x - start) / scale = base + axes y, about isotropic in y

  void go_to(const double* y) {
    const std::size_t n = unknowns.size();
    for (std::size_t k = 0; k < n; ++k) {
      double scaled = base[k];
      for (std::size_t m = 0; m < n; ++m) scaled += axes[k][m] * y[m];
      x[k] = unknowns[k].start + unknowns[k].scale * scaled;
    }
  }

  double at(const double* y, double* gradient) {
    ++evaluations;
    const std::size_t n = unknowns.size();
    go_to(y);
    slope.assign(n, 0.0);
    double cost = 0.0;
    for (std::size_t i = 0; i < data; ++i) {
      const double z = residual(i, x.data(), row.data()) / sigma;
      const bool far = std::abs(z) > (reject ? kReject : kClip);
      cost += !far ? z * z : reject ? kReject * kReject : 2.0 * kClip * std::abs(z) - kClip * kClip;
      if (far && reject) continue;
      const double pull = 2.0 * (far ? (z > 0.0 ? kClip : -kClip) : z) / sigma;
      for (std::size_t k = 0; k < n; ++k) slope[k] += pull * row[k] * unknowns[k].scale;
    }
    for (std::size_t m = 0; gradient && m < n; ++m) {
      gradient[m] = 0.0;
      for (std::size_t k = 0; k < n; ++k) gradient[m] += axes[k][m] * slope[k];
    }
    return cost;
  }
};

double objective(unsigned, const double* x, double* gradient, void* problem) { return static_cast<Problem*>(problem)->at(x, gradient); }

double median(std::vector<double> v) {
  const auto middle = v.begin() + std::ptrdiff_t(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// L^-T of information = L L^T: the axes in which the cost of a linear problem is round. Where data say nothing of an unknown, its own
/// scale stays.
Matrix round_axes(Matrix information, double sigma) {
  const std::size_t n = information.size();
  Matrix lower(n, std::vector<double>(n, 0.0)), axes = lower;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = information[a][b];
      for (std::size_t k = 0; k < b; ++k) sum -= lower[a][k] * lower[b][k];
      if (a != b) lower[a][b] = sum / lower[b][b];
      else lower[a][a] = sum > kBlind * information[a][a] && sum > 0.0 ? std::sqrt(sum) : std::max(std::sqrt(information[a][a]), sigma);
    }
  for (std::size_t m = 0; m < n; ++m)   // column m of L^-T is row m of L^-1
    for (std::size_t a = n; a-- > 0;) {
      double sum = a == m ? sigma : 0.0;
      for (std::size_t k = a + 1; k < n; ++k) sum -= lower[k][a] * axes[k][m];
      axes[a][m] = sum / lower[a][a];
    }
  return axes;
}

}  // namespace

double student_95(double f) {
  constexpr double kExact[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
  if (f < 1.5) return kExact[0];
  if (f <= 10.0) return kExact[std::size_t(f + 0.5) - 1];
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z;  // Cornish and Fisher [Abramowitz and Stegun, 26.7.5]
  return z + (z3 + z) / (4.0 * f) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * f * f);
}

FitResult robust_fit(const std::vector<Unknown>& unknowns, std::size_t data, const Residual& residual, double least_std) {
  const std::size_t n = unknowns.size();
  if (data < n + 2)
    throw Uninformative(std::to_string(data) + " data are too few for " + unknowns.front().name + " and " + std::to_string(n - 1) + " further unknowns");
  Problem p{unknowns, data, residual, 1.0, false, 0, std::vector<double>(n), std::vector<double>(n), std::vector<double>(n, 0.0), {}, {}};
  std::vector<double> y(n, 0.0);
  for (std::size_t k = 0; k < n; ++k) p.x[k] = unknowns[k].start;
  const auto residuals = [&] {
    std::vector<double> r(data);
    for (std::size_t i = 0; i < data; ++i) r[i] = residual(i, p.x.data(), p.row.data());
    return r;
  };
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> off = residuals();
    for (double& r : off) r = std::abs(r);
    // Of few data about a fit the median is too small: n - 0.8 and the degrees of freedom [Croux and Rousseeuw 1992].
    const double few = double(data) / (double(data) - 0.8) * std::sqrt(double(data) / double(data - n));
    p.sigma = std::max(least_std, kMadToStd * few * median(off));
    p.reject = round + 1 == kRounds;
    Matrix information(n, std::vector<double>(n, 0.0));
    for (std::size_t i = 0; i < data; ++i) {
      residual(i, p.x.data(), p.row.data());
      if (p.reject && off[i] > kReject * p.sigma) continue;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) information[a][b] += p.row[a] * p.row[b] * unknowns[a].scale * unknowns[b].scale;
    }
    p.axes = round_axes(std::move(information), p.sigma);
    for (std::size_t k = 0; k < n; ++k) p.base[k] = (p.x[k] - unknowns[k].start) / unknowns[k].scale, y[k] = 0.0;
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(NLOPT_LD_LBFGS, unsigned(n)), nlopt_destroy);
    nlopt_set_min_objective(opt.get(), objective, &p);
    nlopt_set_xtol_abs1(opt.get(), 1e-6);
    nlopt_set_maxeval(opt.get(), kMostEvaluations / kRounds);
    double value = 0.0;
    nlopt_optimize(opt.get(), y.data(), &value);  // a failure (round-off reached) leaves the best point in y
    p.go_to(y.data());
  }

  FitResult f;
  f.data = int(data);
  f.evaluations = p.evaluations;
  std::vector<std::vector<double>> information(n, std::vector<double>(n, 0.0));
  double squares = 0.0;
  const std::vector<double> r = residuals();
  for (std::size_t i = 0; i < data; ++i) {
    const double z = r[i] / p.sigma;
    if (std::abs(z) > kReject) {
      ++f.outliers;
      continue;
    }
    squares += r[i] * r[i];
    residual(i, p.x.data(), p.row.data());
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b) information[a][b] += p.row[a] * p.row[b] * unknowns[a].scale * unknowns[b].scale;
  }
  const double freedom = double(data) - f.outliers - double(n);
  if (freedom < 1.0) throw Uninformative("too many of the data for " + unknowns.front().name + " are outliers");
  f.residual_std = std::max(least_std, std::sqrt(squares / freedom));
  // Inverse by Gauss and Jordan; what is left of a diagonal entry tells how far the unknowns before it can make up for it.
  std::vector<std::vector<double>> inverse(n, std::vector<double>(n, 0.0));
  for (std::size_t k = 0; k < n; ++k) inverse[k][k] = 1.0;
  std::vector<double> whole(n);
  for (std::size_t k = 0; k < n; ++k) whole[k] = information[k][k];
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = information[k][k];
    if (!(pivot > kConfounded * whole[k]) || !(whole[k] > 0.0))
      throw Uninformative("these data cannot tell " + unknowns[k].name + (k > 0 ? " from " + unknowns[0].name : ""));
    for (std::size_t b = 0; b < n; ++b) information[k][b] /= pivot, inverse[k][b] /= pivot;
    for (std::size_t a = 0; a < n; ++a) {
      if (a == k) continue;
      const double by = information[a][k];
      for (std::size_t b = 0; b < n; ++b) information[a][b] -= by * information[k][b], inverse[a][b] -= by * inverse[k][b];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (!(std::abs(p.x[k] - unknowns[k].start) < unknowns[k].reach))
      throw Uninformative(unknowns[k].name + " lies at or beyond the end of its reach, " + std::to_string(p.x[k]));
    const double std = f.residual_std * std::sqrt(inverse[k][k]) * unknowns[k].scale;
    f.unknowns.push_back({p.x[k], std, student_95(freedom) * std});
  }
  return f;
}

}  // namespace firn::calibration
