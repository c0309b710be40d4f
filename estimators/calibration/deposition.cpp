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
  const double x[] = {v.latency_s.value, v.offset_mm.value};
  double g[2];
  for (std::size_t i = 0; i < marks.size(); ++i) v.off_mm.push_back(residual(i, x, g));
  return v;
}

namespace {

/// The mean drop: a sum of terms times what a warmer coil and warmer liquid make of it.
struct DropModel {
  bool by_gap = false, warm = false, tempered = false;
  std::size_t gaps = 0, linear = 0, terms = 0;   ///< unknowns of the sum; all
  double top_hz = 1.0, mean_warmth = 0.0;
  std::vector<std::size_t> joined;  ///< class of each entry of gap_share

  void row(const FlowWeighing& w, double* p) const {
    std::fill(p, p + linear, 0.0);
    if (!by_gap) {  // Legendre on [0, top]: nearly independent of each other
      const double u = 2.0 * w.frequency_hz / top_hz - 1.0;
      p[0] = 1.0, p[1] = u, p[2] = 1.5 * u * u - 0.5;
      if (linear > 3) p[3] = 0.5 * u * (5.0 * u * u - 3.0);
      return;
    }
    for (std::size_t g = 0; g < w.gap_share.size(); ++g) p[joined[g]] += w.gap_share[g];
    p[gaps] = w.frequency_hz / top_hz;
  }
  /// The drop at x, its derivatives into g.
  double drop(const FlowWeighing& w, const double* x, double* g) const {
    row(w, g);
    double sum = 0.0, factor = 1.0;
    for (std::size_t k = 0; k < linear; ++k) sum += x[k] * g[k];
    if (warm) factor += x[linear] * (w.warmth - mean_warmth), g[linear] = sum * (w.warmth - mean_warmth);
    if (tempered) factor += x[terms - 1] * w.warmer_K, g[terms - 1] = sum * w.warmer_K;
    for (std::size_t k = 0; k < linear; ++k) g[k] *= factor;
    return sum * factor;
  }
};

DropModel model_of(std::span<const FlowWeighing> weighings, std::size_t frequencies, double top_hz) {
  DropModel m;
  m.top_hz = top_hz;
  const std::size_t classes = weighings.empty() ? 0 : weighings[0].gap_share.size();
  for (const FlowWeighing& w : weighings) {
    if (w.gap_share.size() != classes) throw std::invalid_argument("some weighings tell the gaps of their pulses and some do not");
    m.warm = m.warm || w.warmth != 0.0;
    m.tempered = m.tempered || w.warmer_K != 0.0;
    m.mean_warmth += w.warmth / double(weighings.size());
  }
  m.by_gap = classes > 0;
  if (!m.by_gap) {
    m.linear = frequencies > 7 ? 4 : 3;
    m.terms = m.linear + (m.warm ? 1 : 0) + (m.tempered ? 1 : 0);
    return m;
  }
  constexpr double kLeastShare = 0.005;
  double share = 0.0;
  for (std::size_t g = 0; g < classes; ++g) {
    m.joined.push_back(m.gaps);
    for (const FlowWeighing& w : weighings) share += w.gap_share[g] / double(weighings.size());
    if (share >= kLeastShare) ++m.gaps, share = 0.0;
  }
  for (std::size_t& g : m.joined) g = std::min(g, m.gaps == 0 ? 0 : m.gaps - 1);
  m.linear = m.gaps + 1;
  m.terms = m.linear + (m.warm ? 1 : 0) + (m.tempered ? 1 : 0);
  return m;
}

/// p^T N^-1 p by Gauss, N positive definite.
double variance_of(std::vector<std::vector<double>> n, const std::vector<double>& p) {
  const std::size_t terms = p.size();
  std::vector<double> y = p;
  for (std::size_t k = 0; k < terms; ++k)
    for (std::size_t a = k + 1; a < terms; ++a) {
      const double by = n[a][k] / n[k][k];
      for (std::size_t b = k; b < terms; ++b) n[a][b] -= by * n[k][b];
      y[a] -= by * y[k];
    }
  for (std::size_t k = terms; k-- > 0;) {
    for (std::size_t b = k + 1; b < terms; ++b) y[k] -= n[k][b] * y[b];
    y[k] /= n[k][k];
  }
  double v = 0.0;
  for (std::size_t k = 0; k < terms; ++k) v += p[k] * y[k];
  return v;
}

}  // namespace

FlowCurveFit calibrate_flow_curve(std::span<const FlowWeighing> weighings) {
  std::vector<const FlowWeighing*> rows;  // one of each frequency
  for (const FlowWeighing& w : weighings) {
    for (const double v : {w.frequency_hz, w.volume_mm3, w.duration_s})
      if (!(std::isfinite(v) && v > 0.0)) throw std::invalid_argument("a weighing has a number that is not above 0");
    rows.push_back(&w);
  }
  std::stable_sort(rows.begin(), rows.end(), [](auto a, auto b) { return a->frequency_hz < b->frequency_hz; });
  rows.erase(std::unique(rows.begin(), rows.end(), [](auto a, auto b) { return a->frequency_hz == b->frequency_hz; }), rows.end());
  if (rows.size() < 5 || rows.back()->frequency_hz < 2.0 * rows.front()->frequency_hz)
    throw Uninformative("a flow curve needs five frequencies over more than a factor of two; there are " + std::to_string(rows.size()));
  const DropModel model = model_of(weighings, rows.size(), rows.back()->frequency_hz);
  const std::size_t terms = model.terms;
  double mean_drop = 0.0, mean_s = 0.0;
  for (const FlowWeighing& w : weighings) mean_s += w.duration_s / double(weighings.size());
  for (const FlowWeighing& w : weighings) mean_drop += w.volume_mm3 / (w.frequency_hz * w.duration_s) / double(weighings.size());
  std::vector<Unknown> unknowns;
  for (std::size_t k = 0; k < terms; ++k) {
    const bool level = model.by_gap ? k < model.gaps : k == 0;
    const double size = k >= model.linear ? 1.0 : mean_drop;
    unknowns.push_back({"the curve's coefficient " + std::to_string(k), level ? mean_drop : 0.0, 0.01 * size, 20.0 * size});
  }
  const Residual residual = [&](std::size_t i, const double* x, double* g) {  // logarithms: a ratio the other way up would be biased
    const FlowWeighing& w = weighings[i];
    const double drop = w.volume_mm3 / (w.frequency_hz * w.duration_s), weight = std::sqrt(w.duration_s / mean_s);
    const double fitted = std::max(model.drop(w, x, g), 1e-3 * mean_drop);
    for (std::size_t k = 0; k < terms; ++k) g[k] *= weight / fitted;
    return weight * std::log(fitted / drop);
  };
  FlowCurveFit out;
  out.fit = robust_fit(unknowns, weighings.size(), residual, 1e-4);
  out.warmth = model.mean_warmth;
  std::vector<std::vector<double>> normal(terms, std::vector<double>(terms, 0.0));
  std::vector<double> row(terms), x(terms);
  for (std::size_t k = 0; k < terms; ++k) x[k] = out.fit.unknowns[k].value;
  for (std::size_t i = 0; i < weighings.size(); ++i) {
    out.relative.push_back(residual(i, x.data(), row.data()));
    if (std::abs(out.relative.back()) > 4.0 * out.fit.residual_std) continue;
    for (std::size_t a = 0; a < terms; ++a)
      for (std::size_t b = 0; b < terms; ++b) normal[a][b] += row[a] * row[b];
  }
  const double t = student_95(double(out.fit.data - out.fit.outliers) - double(terms));
  double before = 0.0;
  for (const FlowWeighing* w : rows) {
    FlowWeighing usual = *w;
    usual.warmth = model.mean_warmth, usual.warmer_K = 0.0;
    const double drop = model.drop(usual, x.data(), row.data());
    const double hz = w->frequency_hz, flow = hz * drop;
    const double std = out.fit.residual_std * std::sqrt(variance_of(normal, row)) * hz;
    if (!(flow > before)) throw Uninformative("the flow does not increase at " + std::to_string(hz) + " Hz");
    if (std > 0.05 * flow) throw Uninformative("the flow at " + std::to_string(hz) + " Hz is known to " + std::to_string(100.0 * std / flow) + " % only");
    before = flow;
    out.rows.push_back({hz, {flow, std, t * std}});
  }
  return out;
}

}  // namespace firn::calibration
