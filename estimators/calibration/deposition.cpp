#include "estimators/calibration/deposition.h"

#include <algorithm>
#include <cmath>

namespace firn::calibration {

ValveLatency calibrate_valve_latency(std::span<const LaidMark> marks) {
  const std::vector<Parameter> parameters{{"valve latency", 0.0, 0.001, 1.0}, {"offset", 0.0, 0.1, 20.0}};
  const Residual residual = [&](std::size_t i, const double* x, double* g) {
    const LaidMark& m = marks[i];
    g[0] = m.speed_mm_s;
    g[1] = 1.0;
    return m.commanded_mm + m.speed_mm_s * x[0] + x[1] - m.measured_mm;
  };
  ValveLatency v;
  v.fit = robust_fit(
      parameters, marks.size(), residual, 0.005,
      Scatter::kHeteroscedastic);  // a start that jitters and an arm that rings move fast marks more
  v.latency_s = v.fit.parameters[0];
  v.offset_mm = v.fit.parameters[1];
  const double x[] = {v.latency_s.value, v.offset_mm.value};
  double g[2];
  for (std::size_t i = 0; i < marks.size(); ++i) v.off_mm.push_back(residual(i, x, g));
  return v;
}

namespace {

constexpr double kMinFlowShare = 0.1;  // of the scatter, that it cannot all be the balance's

/// The mean drop: a sum of terms, less the pressure loss by its flow, times the effect of a warmer coil and
/// warmer liquid.
struct DropModel {
  bool by_gap = false, warm = false, tempered = false;
  std::size_t gaps = 0, linear = 0, terms = 0;  ///< parameters of the sum, with the pressure's; all
  double top_hz = 1.0, usual_mm3 = 1.0, mean_warmth = 0.0;
  std::vector<std::size_t> joined;  ///< class of each entry of gap_share

  void row(const FlowWeighing& w, double* p) const {
    std::fill(p, p + linear, 0.0);
    if (!by_gap) {  // Legendre on [0, top]: nearly independent of each other
      const double u = 2.0 * w.frequency_hz / top_hz - 1.0;
      p[0] = 1.0;
      p[1] = u;
      p[2] = 1.5 * u * u - 0.5;
      if (linear > 3) p[3] = 0.5 * u * (5.0 * u * u - 3.0);
      return;
    }
    for (std::size_t g = 0; g < w.gap_share.size(); ++g) p[joined[g]] += w.gap_share[g];
  }
  /// Gaps that few pulses have share their parameter with the next.
  void join_gaps(std::span<const FlowWeighing> weighings) {
    constexpr double kMinShare = 0.005;
    double share = 0.0;
    for (std::size_t g = 0; g < weighings[0].gap_share.size(); ++g) {
      joined.push_back(gaps);
      for (const FlowWeighing& w : weighings) share += w.gap_share[g] / double(weighings.size());
      if (share >= kMinShare) {
        ++gaps;
        share = 0.0;
      }
    }
    for (std::size_t& g : joined) g = std::min(g, gaps == 0 ? 0 : gaps - 1);
    linear = gaps + 1;
  }
  /// The drop at x, its derivatives into g.
  double drop(const FlowWeighing& w, const double* x, double* g) const {
    row(w, g);
    double sum = 0.0, factor = 1.0;
    for (std::size_t k = 0; k < linear; ++k) sum += x[k] * g[k];
    if (by_gap) {
      const double flow = w.frequency_hz / top_hz * sum / (usual_mm3 * usual_mm3);
      for (std::size_t k = 0; k < gaps; ++k) g[k] *= 1.0 + 2.0 * x[gaps] * flow;
      g[gaps] = flow * sum;
      sum += x[gaps] * g[gaps];
    }
    if (warm) {
      factor += x[linear] * (w.warmth - mean_warmth) + x[linear + 1] * w.warmth_lag;
      g[linear] = sum * (w.warmth - mean_warmth);
      g[linear + 1] = sum * w.warmth_lag;
    }
    if (tempered) {
      factor += x[terms - 1] * w.warmer_K;
      g[terms - 1] = sum * w.warmer_K;
    }
    for (std::size_t k = 0; k < linear; ++k) g[k] *= factor;
    return sum * factor;
  }
};

DropModel model_of(std::span<const FlowWeighing> weighings, std::size_t frequencies, double top_hz,
                   double mean_drop) {
  DropModel m;
  m.top_hz = top_hz;
  m.usual_mm3 = mean_drop;
  const std::size_t classes = weighings.empty() ? 0 : weighings[0].gap_share.size();
  for (const FlowWeighing& w : weighings) {
    if (w.gap_share.size() != classes)
      throw std::invalid_argument("some weighings tell the gaps of their pulses and some do not");
    m.warm = m.warm || w.warmth != 0.0;
    m.tempered = m.tempered || w.warmer_K != 0.0;
    m.mean_warmth += w.warmth / double(weighings.size());
  }
  m.by_gap = classes > 0;
  if (!m.by_gap)
    m.linear = frequencies > 7 ? 4 : 3;
  else
    m.join_gaps(weighings);
  m.terms = m.linear + (m.warm ? 2 : 0) + (m.tempered ? 1 : 0);
  return m;
}

}  // namespace

void check_flow_frequencies(std::vector<double> hz) {
  std::ranges::sort(hz);
  hz.erase(std::unique(hz.begin(), hz.end()), hz.end());
  if (hz.size() < 5 || hz.back() < 2.0 * hz.front())
    throw Unidentifiable("a flow curve needs five frequencies over more than a factor of two; there are " +
                         std::to_string(hz.size()));
}

FlowCurveFit calibrate_flow_curve(std::span<const FlowWeighing> weighings) {
  std::vector<const FlowWeighing*> rows;  // one of each frequency
  for (const FlowWeighing& w : weighings) {
    for (const double v : {w.frequency_hz, w.volume_mm3, w.duration_s})
      if (!(std::isfinite(v) && v > 0.0))
        throw std::invalid_argument("a weighing has a number that is not above 0");
    rows.push_back(&w);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](auto a, auto b) { return a->frequency_hz < b->frequency_hz; });
  rows.erase(std::unique(rows.begin(), rows.end(),
                         [](auto a, auto b) { return a->frequency_hz == b->frequency_hz; }),
             rows.end());
  std::vector<double> frequencies;
  for (const FlowWeighing* w : rows) frequencies.push_back(w->frequency_hz);
  check_flow_frequencies(std::move(frequencies));
  double mean_drop = 0.0, mean_s = 0.0;
  for (const FlowWeighing& w : weighings) mean_s += w.duration_s / double(weighings.size());
  for (const FlowWeighing& w : weighings)
    mean_drop += w.volume_mm3 / (w.frequency_hz * w.duration_s) / double(weighings.size());
  const DropModel model = model_of(weighings, rows.size(), rows.back()->frequency_hz, mean_drop);
  const std::size_t terms = model.terms;
  std::vector<Parameter> parameters;
  for (std::size_t k = 0; k < terms; ++k) {
    const bool level = model.by_gap ? k < model.gaps : k == 0;
    const double size = k >= model.linear ? 1.0 : mean_drop;
    parameters.push_back(
        {"the curve's coefficient " + std::to_string(k), level ? mean_drop : 0.0, 0.01 * size, 20.0 * size});
  }
  std::vector<double> weight;
  for (const FlowWeighing& w : weighings) weight.push_back(std::sqrt(w.duration_s / mean_s));
  const Residual residual = [&](std::size_t i, const double* x,
                                double* g) {  // logarithms: a ratio the other way up would be biased
    const FlowWeighing& w = weighings[i];
    const double drop = w.volume_mm3 / (w.frequency_hz * w.duration_s);
    const double fitted = std::max(model.drop(w, x, g), 1e-3 * mean_drop);
    for (std::size_t k = 0; k < terms; ++k) g[k] *= weight[i] / fitted;
    return weight[i] * std::log(fitted / drop);
  };
  FlowCurveFit out;
  out.fit = robust_fit(parameters, weighings.size(), residual, 1e-4);
  // The balance's share of the scatter is known, the flow's is the rest; once more with both.
  const auto balance = [&](std::size_t i) {
    return std::pow(weighings[i].balance_mm3 / weighings[i].volume_mm3, 2);
  };
  double flows = 0.0, balances = 0.0;
  for (std::size_t n = 0; n < out.fit.used.size(); ++n) {
    const std::size_t i = out.fit.used[n];
    flows += out.fit.residuals[n] * out.fit.residuals[n];
    balances += balance(i) * weight[i] * weight[i];
  }
  if (balances > 0.0) {
    const double flow = std::max(flows - balances, kMinFlowShare * flows) / double(out.fit.used.size());
    for (std::size_t i = 0; i < weighings.size(); ++i)
      weight[i] = 1.0 / std::sqrt(mean_s / weighings[i].duration_s + balance(i) / flow);
    out.fit = robust_fit(parameters, weighings.size(), residual, 1e-4);
  }
  out.warmth = model.mean_warmth;
  std::vector<double> row(terms), x(terms);
  for (std::size_t k = 0; k < terms; ++k) x[k] = out.fit.parameters[k].value;
  for (std::size_t i = 0; i < weighings.size(); ++i)
    out.relative.push_back(residual(i, x.data(), row.data()));
  double before = 0.0;
  for (const FlowWeighing* w : rows) {
    FlowWeighing usual = *w;
    usual.warmth = model.mean_warmth;
    usual.warmth_lag = usual.warmer_K = 0.0;
    const double hz = w->frequency_hz, flow = hz * model.drop(usual, x.data(), row.data());
    for (double& by : row) by *= hz;
    const Estimate e = out.fit.estimate(flow, row);
    if (!(flow > before)) throw Unidentifiable("the flow does not increase at " + std::to_string(hz) + " Hz");
    if (e.std > 0.05 * flow)
      throw Unidentifiable("the flow at " + std::to_string(hz) + " Hz is known to " +
                           std::to_string(100.0 * e.std / flow) + " % only");
    before = flow;
    out.rows.push_back({hz, e});
  }
  return out;
}

}  // namespace firn::calibration
