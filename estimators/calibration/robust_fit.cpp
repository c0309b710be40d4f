#include "estimators/calibration/robust_fit.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "core/statistics/distributions.h"
#include "core/statistics/median.h"

namespace firn::calibration {
namespace {

constexpr double kClip = 3.0, kReject = 4.0, kConfounded = 1e-4, kBlind = 1e-10, kOwn = 1e-9;
constexpr int kRounds = 4, kMaxEvaluations = 1000;

using Matrix = std::vector<std::vector<double>>;

struct Problem {
  const std::vector<Parameter>& parameters;
  std::size_t data;
  const Residual& residual;
  double sigma = 1.0;
  bool reject = false;  ///< residuals beyond the clip have no influence
  long evaluations = 0;
  std::vector<double> x, row;       // of the caller's parameters
  std::vector<double> base, slope;  // (x - start) / scale where the round began; the gradient by it
  Matrix axes;                      // NLopt's y: (x - start) / scale = base + axes y, about isotropic in y

  void go_to(const double* y) {
    const std::size_t n = parameters.size();
    for (std::size_t k = 0; k < n; ++k) {
      double scaled = base[k];
      for (std::size_t m = 0; m < n; ++m) scaled += axes[k][m] * y[m];
      x[k] = parameters[k].start + parameters[k].scale * scaled;
    }
  }

  double at(const double* y, double* gradient) {
    ++evaluations;
    const std::size_t n = parameters.size();
    go_to(y);
    slope.assign(n, 0.0);
    double cost = 0.0;
    for (std::size_t i = 0; i < data; ++i) {
      const double z = residual(i, x.data(), row.data()) / sigma;
      const bool far = std::abs(z) > (reject ? kReject : kClip);
      cost += !far ? z * z : reject ? kReject * kReject : 2.0 * kClip * std::abs(z) - kClip * kClip;
      if (far && reject) continue;
      const double influence = 2.0 * (far ? (z > 0.0 ? kClip : -kClip) : z) / sigma;
      for (std::size_t k = 0; k < n; ++k) slope[k] += influence * row[k] * parameters[k].scale;
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

/// L^-T of information = L L^T: the axes in which the cost of a linear problem is isotropic. A parameter
/// without information keeps its own scale: this is why Eigen's LLT does not serve.
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

FitResult robust_fit(const std::vector<Parameter>& parameters, std::size_t data, const Residual& residual,
                     double min_std, Scatter scatter) {
  const std::size_t n = parameters.size();
  if (data < n + 2)
    throw Unidentifiable(std::to_string(data) + " data are too few for " + parameters.front().name + " and " +
                         std::to_string(n - 1) + " further unknowns");
  Problem p{parameters,
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
  for (std::size_t k = 0; k < n; ++k) p.x[k] = parameters[k].start;
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
    p.sigma = std::max(min_std, statistics::kMadToStd * few * statistics::upper_median(off));
    p.reject = round + 1 == kRounds;
    Matrix information(n, std::vector<double>(n, 0.0));
    for (std::size_t i = 0; i < data; ++i) {
      residual(i, p.x.data(), p.row.data());
      if (p.reject && off[i] > kReject * p.sigma) continue;
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
          information[a][b] += p.row[a] * p.row[b] * parameters[a].scale * parameters[b].scale;
    }
    p.axes = round_axes(std::move(information), p.sigma);
    for (std::size_t k = 0; k < n; ++k) {
      p.base[k] = (p.x[k] - parameters[k].start) / parameters[k].scale;
      y[k] = 0.0;
    }
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> opt(nlopt_create(NLOPT_LD_LBFGS, unsigned(n)),
                                                                nlopt_destroy);
    nlopt_set_min_objective(opt.get(), objective, &p);
    nlopt_set_xtol_abs1(opt.get(), 1e-6);
    nlopt_set_maxeval(opt.get(), kMaxEvaluations / kRounds);
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
        information[a][b] += p.row[a] * p.row[b] * parameters[a].scale * parameters[b].scale;
    f.rows.push_back(p.row);
    f.residuals.push_back(r[i]);
    f.used.push_back(i);
  }
  const double freedom = double(data) - f.outliers - double(n);
  if (freedom < 1.0)
    throw Unidentifiable("too many of the data for " + parameters.front().name + " are outliers");
  f.min_std = min_std;
  f.scatter = scatter;
  f.residual_std = std::max(min_std, std::sqrt(squares / freedom));
  // Inverse by Gauss and Jordan. The rest of a diagonal entry shows how far the parameters before it can
  // replace it.
  Matrix& inverse = f.inverse;
  inverse.assign(n, std::vector<double>(n, 0.0));
  for (std::size_t k = 0; k < n; ++k) inverse[k][k] = 1.0;
  std::vector<double> whole(n);
  for (std::size_t k = 0; k < n; ++k) whole[k] = information[k][k];
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = information[k][k];
    if (!(pivot > kConfounded * whole[k]) || !(whole[k] > 0.0))
      throw Unidentifiable("these data cannot tell " + parameters[k].name +
                           (k > 0 ? " from " + parameters[0].name : ""));
    for (std::size_t b = 0; b < n; ++b) {
      information[k][b] /= pivot;
      inverse[k][b] /= pivot;
    }
    for (std::size_t a = 0; a < n; ++a) {
      if (a == k) continue;
      const double by = information[a][k];
      for (std::size_t b = 0; b < n; ++b) {
        information[a][b] -= by * information[k][b];
        inverse[a][b] -= by * inverse[k][b];
      }
    }
  }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) inverse[a][b] *= parameters[a].scale * parameters[b].scale;
  for (std::size_t k = 0; k < n; ++k) {
    if (!(std::abs(p.x[k] - parameters[k].start) < parameters[k].bound))
      throw Unidentifiable(parameters[k].name + " lies at or beyond the end of its reach, " +
                           std::to_string(p.x[k]));
    std::vector<double> itself(n, 0.0);
    itself[k] = 1.0;
    f.parameters.push_back(f.estimate(p.x[k], itself));
  }
  return f;
}

Estimate FitResult::estimate(double value, const std::vector<double>& by_parameter) const {
  const std::size_t n = by_parameter.size(), m = rows.size();
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  const auto solve = [&](const std::vector<double>& v) {
    std::vector<double> out(n);
    for (std::size_t a = 0; a < n; ++a) out[a] = dot(inverse[a], v);
    return out;
  };
  const std::vector<double> direction = solve(by_parameter);
  if (scatter == Scatter::kHomoscedastic) {
    const double std = residual_std * std::sqrt(dot(direction, by_parameter));
    return {value, std, statistics::student_t_95(double(m) - double(n)) * std};
  }
  Matrix solved(m);
  std::vector<double> weight(m, 0.0);  // of each squared residual in the variance
  double variance = 0.0, least = 0.0;
  for (std::size_t i = 0; i < m; ++i) {
    solved[i] = solve(rows[i]);
    const double share = dot(direction, rows[i]),
                 left = 1.0 - dot(rows[i], solved[i]);  // share of a datum's own error in its residual
    if (left > kOwn) weight[i] = share * share / left;
    variance +=
        left > kOwn ? weight[i] * residuals[i] * residuals[i] : share * share * residual_std * residual_std;
    least += share * share * min_std * min_std;
  }
  double trace = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < m; ++i)
    for (std::size_t j = 0; j < m; ++j) {
      const double left = (i == j ? 1.0 : 0.0) - dot(rows[i], solved[j]);
      if (i == j) trace += weight[i] * left;
      squares += weight[i] * weight[j] * left * left;
    }
  const double std = std::sqrt(std::max(variance, least));
  return {value, std, statistics::student_t_95(squares > 0.0 ? trace * trace / squares : 1.0) * std};
}

}  // namespace firn::calibration
