#include "core/control/smf_line/smf_line.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "core/grid/random.h"

namespace firn::control::smf_line {

std::vector<double> disturbance(const DisturbanceModel& m) {
  if (m.intervals < 1)
    throw std::invalid_argument("intervals = " + std::to_string(m.intervals) + " is below 1");
  for (const double part : {m.pulse, m.step, m.random})
    if (!std::isfinite(part)) throw std::invalid_argument("a part of the disturbance is not finite");
  std::vector<double> d(std::size_t(m.intervals), 0.0);
  for (int k = 1; k <= m.intervals; ++k) {
    double& here = d[std::size_t(k - 1)];
    if (k == m.pulse_at) here += m.pulse;
    if (k >= m.step_at) here += m.step;
    if (m.random != 0.0 && k >= m.random_at)
      here += m.random * (random_uniform({m.seed, Purpose::kDisturbance, std::uint32_t(k), 0, 0}) - 0.5);
  }
  return d;
}

void simulate(const Gains& g, std::span<const double> d, std::span<double> errors,
              std::span<double> actions) {
  double e = 0.0, before = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < d.size(); ++k) {
    errors[k] = e;
    sum += e;
    const double u = g.kp * e + g.ki_star * sum + (k ? g.kd_star * (e - before) : 0.0);
    if (!actions.empty()) actions[k] = u;
    before = e;
    e = e - u - d[k];
  }
}

Spread spread(const Gains& g, std::span<const double> d) {
  using Vector = std::array<double, 3>;
  double e = 0.0, before = 0.0, sum = 0.0, squares = 0.0;
  Vector de{}, de_before{}, de_sum{}, product{};
  for (std::size_t k = 0; k < d.size(); ++k) {
    squares += e * e;
    sum += e;
    const double difference = k ? e - before : 0.0;
    const double u = g.kp * e + g.ki_star * sum + g.kd_star * difference;
    const Vector direct{e, sum, difference};
    for (std::size_t i = 0; i < 3; ++i) {
      product[i] += e * de[i];
      de_sum[i] += de[i];
      const double du =
          direct[i] + g.kp * de[i] + g.ki_star * de_sum[i] + (k ? g.kd_star * (de[i] - de_before[i]) : 0.0);
      de_before[i] = de[i];
      de[i] -= du;
    }
    before = e;
    e = e - u - d[k];
  }
  Spread s;
  s.rms = std::sqrt(squares / double(d.size()));
  if (s.rms > 0.0)
    for (std::size_t i = 0; i < 3; ++i) s.gradient[i] = product[i] / (s.rms * double(d.size()));
  return s;
}

std::array<double, 3> characteristic(const Gains& g) {
  return {g.kd_star, 1.0 - g.kp - 2.0 * g.kd_star, g.kp + g.ki_star + g.kd_star - 2.0};
}

std::array<std::complex<double>, 3> poles(const Gains& gains) {
  const auto [c0, c1, c2] = characteristic(gains);
  // One real root always exists: bisection between the signs, then the other two from the deflated quadratic.
  const auto p = [&, c0 = c0, c1 = c1, c2 = c2](double z) { return ((z + c2) * z + c1) * z + c0; };
  const double reach = 1.0 + std::max({std::abs(c0), std::abs(c1), std::abs(c2)});  // Cauchy's bound
  double low = -reach, high = reach;
  for (int n = 0; n < 200 && low < high; ++n) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (p(middle) < 0.0 ? low : high) = middle;
  }
  const double real = std::abs(p(low)) < std::abs(p(high)) ? low : high;
  // z^2 + b z + c; c from the side that does not cancel
  const double b = c2 + real, c = c1 + real * b;
  const double quarter = 0.25 * b * b - c;
  std::array<std::complex<double>, 3> z{real, 0.0, 0.0};
  if (quarter < 0.0) {
    z[1] = {-0.5 * b, std::sqrt(-quarter)};
    z[2] = std::conj(z[1]);
  } else {
    const double far = -0.5 * b - std::copysign(std::sqrt(quarter), b);
    z[1] = far;
    z[2] = far != 0.0 ? c / far : 0.0;
  }
  std::sort(z.begin(), z.end(), [](const auto& x, const auto& y) {
    const double nx = std::norm(x), ny = std::norm(y);
    return nx != ny ? nx > ny : x.imag() > y.imag();
  });
  return z;
}

double largest_pole(const Gains& gains) { return std::abs(poles(gains)[0]); }

double stability_margin(const Gains& g) {
  const double cross = g.kd_star * (g.kp + g.ki_star);
  return std::min({g.ki_star, 1.0 - 0.5 * g.kp - 0.25 * g.ki_star - g.kd_star, 1.0 - std::abs(g.kd_star),
                   g.kp + cross, 2.0 - g.kp - cross - 2.0 * g.kd_star * g.kd_star});
}

bool stable(const Gains& gains) { return stability_margin(gains) > 0.0; }

std::vector<double> disturbance_of(std::span<const double> errors, std::span<const double> actions) {
  if (errors.size() < 2 || actions.size() + 1 < errors.size())
    throw std::invalid_argument(
        "a disturbance needs two errors and an action before each but the first; there are " +
        std::to_string(errors.size()) + " errors and " + std::to_string(actions.size()) + " actions");
  std::vector<double> d(errors.size() - 1);
  for (std::size_t k = 0; k < d.size(); ++k) d[k] = errors[k] - actions[k] - errors[k + 1];
  return d;
}

}  // namespace firn::control::smf_line
