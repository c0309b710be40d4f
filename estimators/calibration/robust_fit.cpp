#include "estimators/calibration/robust_fit.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

namespace firn::calibration {
namespace {

constexpr double kClip = 3.0, kReject = 4.0, kMadToStd = 1.4826, kConfounded = 1e-4, kBlind = 1e-10,
                 kOwn = 1e-9;
constexpr int kRounds = 4, kMostEvaluations = 1000;

using Matrix = std::vector<std::vector<double>>;

struct Problem {
  const std::vector<Unknown>& unknowns;
  std::size_t data;
  const Residual& residual;
  double sigma = 1.0;
  bool reject = false;  ///< what lies beyond the clip pulls no more
  long evaluations = 0;
  std::vector<double> x, row;       // of the caller's unknowns
  std::vector<double> base, slope;  // (x - start) / scale where the round began; the gradient by it
  Matrix axes;                      // NLopt's y: (x - start) / scale = base + axes y, about isotropic in y

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

double objective(unsigned, const double* x, double* gradient, void* problem) {
  return static_cast<Problem*>(problem)->at(x, gradient);
}

double median(std::vector<double> v) {
  const auto middle = v.begin() + std::ptrdiff_t(v.size() / 2);
  std::nth_element(v.begin(), middle, v.end());
  return *middle;
}

/// L^-T of information = L L^T: the axes in which the cost of a linear problem is round. Where data say
/// nothing of an unknown, its own scale stays.
Matrix round_axes(Matrix information, double sigma) {
  const std::size_t n = information.size();
  Matrix lower(n, std::vector<double>(n, 0.0)), axes = lower;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      double sum = information[a][b];
      for (std::size_t k = 0; k < b; ++k) sum -= lower[a][k] * lower[b][k];
      if (a != b)
        lower[a][b] = sum / lower[b][b];
      else
        lower[a][a] = sum > kBlind * information[a][a] && sum > 0.0
                          ? std::sqrt(sum)
                          : std::max(std::sqrt(information[a][a]), sigma);
    }
  for (std::size_t m = 0; m < n; ++m)  // column m of L^-T is row m of L^-1
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
  const double z = 1.959964, z3 = z * z * z,
               z5 = z3 * z * z;  // Cornish and Fisher [Abramowitz and Stegun, 26.7.5]
  return z + (z3 + z) / (4.0 * f) + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * f * f);
}

FitResult robust_fit(const std::vector<Unknown>& unknowns, std::size_t data, const Residual& residual,
                     double least_std, Scatter scatter) {
  const std::size_t n = unknowns.size();
  if (data < n + 2)
    throw Uninformative(std::to_string(data) + " data are too few for " + unknowns.front().name + " and " +
                        std::to_string(n - 1) + " further unknowns");
  Problem p{unknowns,
            data,
            residual,
            1.0,
            false,
            0,
            std::vector<double>(n),
            std::vector<double>(n),
            std::vector<double>(n, 0.0),
            {},
            {}};
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
    // Of few data about a fit the median is too small: n - 0.8 and the degrees of freedom [Croux and
    // Rousseeuw 1992].
    const double few = double(data) / (double(data) - 0.8) * std::sqrt(double(data) / double(data - n));
    p.sigma = std::max(least_std, kMadToStd * few * median(off));
    p.reject = round + 1 == kRounds;
    Matrix information(n, std::vector<double>(n, 0.0));
    for (std::size_t i = 0; i < data; ++i) {
      residual(i, p.x.data(), p.row.data());
      if (p.reject && off[i] > kReject * p.sigma) continue;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
          information[a][b] += p.row[a] * p.row[b] * unknowns[a].scale * unknowns[b].scale;
    }
    p.axes = round_axes(std::move(information), p.sigma);
    for (std::size_t k = 0; k < n; ++k)
      p.base[k] = (p.x[k] - unknowns[k].start) / unknowns[k].scale, y[k] = 0.0;
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(NLOPT_LD_LBFGS, unsigned(n)),
                                                                nlopt_destroy);
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
  Matrix information(n, std::vector<double>(n, 0.0));
  double squares = 0.0;
  const std::vector<double> r = residuals();
  for (std::size_t i = 0; i < data; ++i) {
    if (std::abs(r[i]) > kReject * p.sigma) {
      ++f.outliers;
      continue;
    }
    squares += r[i] * r[i];
    residual(i, p.x.data(), p.row.data());
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        information[a][b] += p.row[a] * p.row[b] * unknowns[a].scale * unknowns[b].scale;
    f.rows.push_back(p.row), f.residuals.push_back(r[i]), f.used.push_back(i);
  }
  const double freedom = double(data) - f.outliers - double(n);
  if (freedom < 1.0)
    throw Uninformative("too many of the data for " + unknowns.front().name + " are outliers");
  f.least_std = least_std, f.scatter = scatter;
  f.residual_std = std::max(least_std, std::sqrt(squares / freedom));
  // Inverse by Gauss and Jordan; what is left of a diagonal entry tells how far the unknowns before it can
  // make up for it.
  Matrix& inverse = f.inverse;
  inverse.assign(n, std::vector<double>(n, 0.0));
  for (std::size_t k = 0; k < n; ++k) inverse[k][k] = 1.0;
  std::vector<double> whole(n);
  for (std::size_t k = 0; k < n; ++k) whole[k] = information[k][k];
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = information[k][k];
    if (!(pivot > kConfounded * whole[k]) || !(whole[k] > 0.0))
      throw Uninformative("these data cannot tell " + unknowns[k].name +
                          (k > 0 ? " from " + unknowns[0].name : ""));
    for (std::size_t b = 0; b < n; ++b) information[k][b] /= pivot, inverse[k][b] /= pivot;
    for (std::size_t a = 0; a < n; ++a) {
      if (a == k) continue;
      const double by = information[a][k];
      for (std::size_t b = 0; b < n; ++b)
        information[a][b] -= by * information[k][b], inverse[a][b] -= by * inverse[k][b];
    }
  }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) inverse[a][b] *= unknowns[a].scale * unknowns[b].scale;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(std::abs(p.x[k] - unknowns[k].start) < unknowns[k].reach))
      throw Uninformative(unknowns[k].name + " lies at or beyond the end of its reach, " +
                          std::to_string(p.x[k]));
    std::vector<double> itself(n, 0.0);
    itself[k] = 1.0;
    f.unknowns.push_back(f.estimate(p.x[k], itself));
  }
  return f;
}

Estimate FitResult::estimate(double value, const std::vector<double>& by_unknown) const {
  const std::size_t n = by_unknown.size(), m = rows.size();
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const auto solve = [&](const std::vector<double>& v) {
    std::vector<double> out(n);
    for (std::size_t a = 0; a < n; ++a) out[a] = dot(inverse[a], v);
    return out;
  };
  const std::vector<double> pull = solve(by_unknown);
  if (scatter == Scatter::kAlike) {
    const double std = residual_std * std::sqrt(dot(pull, by_unknown));
    return {value, std, student_95(double(m) - double(n)) * std};
  }
  Matrix solved(m);
  std::vector<double> weight(m, 0.0);  // of each squared residual in the variance
  double variance = 0.0, least = 0.0;
  for (std::size_t i = 0; i < m; ++i) {
    solved[i] = solve(rows[i]);
    const double share = dot(pull, rows[i]),
                 left = 1.0 - dot(rows[i], solved[i]);  // what the fit leaves of a datum's own error
    if (left > kOwn) weight[i] = share * share / left;
    variance +=
        left > kOwn ? weight[i] * residuals[i] * residuals[i] : share * share * residual_std * residual_std;
    least += share * share * least_std * least_std;
  }
  double trace = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < m; ++i)
    for (std::size_t j = 0; j < m; ++j) {
      const double left = (i == j ? 1.0 : 0.0) - dot(rows[i], solved[j]);
      if (i == j) trace += weight[i] * left;
      squares += weight[i] * weight[j] * left * left;
    }
  const double std = std::sqrt(std::max(variance, least));
  return {value, std, student_95(squares > 0.0 ? trace * trace / squares : 1.0) * std};
}

}  // namespace firn::calibration
