#include "estimators/calibration/deposition.h"

#include <algorithm>
#include <cmath>

namespace firn::calibration {

ValveLatency calibrate_valve_latency(std::span<const LaidMark> marks) {
  const std::vector<Unknown> unknowns{{"valve latency", 0.0, 0.001, 1.0}, {"offset", 0.0, 0.1, 20.0}};
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const LaidMark& m = marks[i];
    g[0] = m.speed_mm_s, g[1] = 1.0;
    return m.commanded_mm + m.speed_mm_s * x[0] + x[1] - m.measured_mm;
  };
  ValveLatency v;
  v.fit = robust_fit(unknowns, marks.size(), residual, 0.005);
  v.latency_s = v.fit.unknowns[0], v.offset_mm = v.fit.unknowns[1];
  return v;
}

FlowCurveFit calibrate_flow_curve(std::span<const FlowWeighing> weighings) {
  std::vector<double> frequencies;
  for (const FlowWeighing& w : weighings) {
    for (const double v : {w.frequency_hz, w.volume_mm3, w.duration_s})
      if (!(std::isfinite(v) && v > 0.0)) throw std::invalid_argument("a weighing has a number that is not above 0");
    frequencies.push_back(w.frequency_hz);
  }
  std::sort(frequencies.begin(), frequencies.end());
  frequencies.erase(std::unique(frequencies.begin(), frequencies.end()), frequencies.end());
  if (frequencies.size() < 5 || frequencies.back() < 2.0 * frequencies.front())
    throw Uninformative("a flow curve needs five frequencies over more than a factor of two; there are " + std::to_string(frequencies.size()));
  const std::size_t terms = frequencies.size() > 7 ? 4 : 3;
  const double top_hz = frequencies.back();
  double mean_drop = 0.0;
  for (const FlowWeighing& w : weighings) mean_drop += w.volume_mm3 / (w.frequency_hz * w.duration_s) / double(weighings.size());
  std::vector<Unknown> unknowns;
  for (std::size_t k = 0; k < terms; ++k) unknowns.push_back({"the curve's coefficient " + std::to_string(k), k == 0 ? mean_drop : 0.0, 0.01 * mean_drop, 20.0 * mean_drop});
  const auto legendre = [&](double hz, double* p) {  // on [0, top]: nearly independent of each other
    const double u = 2.0 * hz / top_hz - 1.0;
    p[0] = 1.0, p[1] = u, p[2] = 1.5 * u * u - 0.5;
    if (terms > 3) p[3] = 0.5 * u * (5.0 * u * u - 3.0);
  };
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const FlowWeighing& w = weighings[i];
    const double drop = w.volume_mm3 / (w.frequency_hz * w.duration_s);
    legendre(w.frequency_hz, g);
    double fitted = 0.0;
    for (std::size_t k = 0; k < terms; ++k) fitted += x[k] * g[k], g[k] /= drop;
    return fitted / drop - 1.0;
  };
  FlowCurveFit out;
  out.fit = robust_fit(unknowns, weighings.size(), residual, 1e-4);
  // The curve's own standard deviation where it was weighed: (J (J^T J)^-1 J^T) by fitting unit vectors is dear; each row's variance
  // from the normal equations solved once per frequency.
  std::vector<std::vector<double>> normal(terms, std::vector<double>(terms, 0.0));
  std::vector<double> row(terms), x(terms);
  for (std::size_t k = 0; k < terms; ++k) x[k] = out.fit.unknowns[k].value;
  for (std::size_t i = 0; i < weighings.size(); ++i) {
    if (std::abs(residual(i, x.data(), row.data())) > 3.0 * out.fit.residual_std) continue;
    for (std::size_t a = 0; a < terms; ++a)
      for (std::size_t b = 0; b < terms; ++b) normal[a][b] += row[a] * row[b];
  }
  const double t = student_95(double(out.fit.data - out.fit.outliers) - double(terms));
  double before = 0.0;
  for (const double hz : frequencies) {
    double p[4];
    legendre(hz, p);
    std::vector<std::vector<double>> m = normal;
    std::vector<double> y(p, p + terms);
    for (std::size_t k = 0; k < terms; ++k)  // Gauss, positive definite
      for (std::size_t a = k + 1; a < terms; ++a) {
        const double by = m[a][k] / m[k][k];
        for (std::size_t b = k; b < terms; ++b) m[a][b] -= by * m[k][b];
        y[a] -= by * y[k];
      }
    double drop = 0.0, variance = 0.0;
    for (std::size_t k = terms; k-- > 0;) {
      for (std::size_t b = k + 1; b < terms; ++b) y[k] -= m[k][b] * y[b];
      y[k] /= m[k][k];
    }
    for (std::size_t k = 0; k < terms; ++k) drop += x[k] * p[k], variance += p[k] * y[k];
    const double std = out.fit.residual_std * std::sqrt(variance) * hz;
    const double flow = hz * drop;
    if (!(flow > before)) throw Uninformative("the flow does not increase at " + std::to_string(hz) + " Hz");
    if (std > 0.05 * flow) throw Uninformative("the flow at " + std::to_string(hz) + " Hz is known to " + std::to_string(100.0 * std / flow) + " % only");
    before = flow;
    out.rows.push_back({hz, {flow, std, t * std}});
  }
  return out;
}

}  // namespace firn::calibration
