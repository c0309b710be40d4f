#include "estimators/droplet/droplet_estimator.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/options/require.h"
#include "estimators/droplet/huber.h"

namespace firn::droplet {
namespace {

using deposition::DropletModel;

constexpr int kReach = 2;       // cells up to so far apart may share a droplet
constexpr double kStep = 1e-3;  // of the derivatives, relative
constexpr double kMaxScatter = 0.5;
constexpr double kGroundShift_mm = 1e-3;  // for the derivative by the substrate's height

constexpr double kClippedSquare = 0.995;  // mean of the clipped square of a normal variable
constexpr double kMinNoiseScale = 0.25;   // of the variance that the maps report
constexpr int kMaxRounds = 5;
constexpr double kSettled = 3e-4;
constexpr double kAtBound = 1e-3;  // of the prior: nearer to the end of its range, a constant is at its bound
constexpr std::array<double, 3> kLayerHeight{1.0, 4.0, 4.0};  // h1 + 4 h2 + 4 h3

std::array<double, 3> values(const DropletModel& m) { return {m.h1_mm, m.h2_mm, m.h3_mm}; }
DropletModel model_of(const double* h) { return {h[0], h[1], h[2]}; }

// A scale for each of h1..h3 even where its estimate is 0.
std::array<double, 3> scales(const DropletModel& m) {
  return {m.h1_mm, std::max(m.h2_mm, 0.05 * m.h1_mm), std::max(m.h3_mm, 0.05 * m.h1_mm)};
}

void estimator_needs(bool ok, std::string_view what) { firn::require(ok, "droplet estimator", what); }

}  // namespace

double Estimate::std_mm(int n) const { return std::sqrt(std::max(0.0, covariance_mm2.at(n, n))); }
double Estimate::layer_height_std_mm() const {
  return std::sqrt(std::max(0.0, covariance_mm2.form(kLayerHeight)));
}

struct DropletEstimator::Work {
  std::vector<double> height, difference;
  std::vector<std::vector<double>> at_best;               // differences per layer
  std::array<std::vector<std::vector<double>>, 3> slope;  // d predicted / d h, per layer
  std::vector<CellTerms> cell;
};

DropletEstimator::DropletEstimator(const GridSpec& grid, const EstimatorOptions& options)
    : grid_(grid),
      options_(options),
      filter_(grid, options.border),
      model_(options.prior),
      old_(grid.size()),
      work_(std::make_unique<Work>()) {
  firn::check(grid);
  deposition::check(options.prior);
  check_options("droplet estimator", kEstimatorOptions, options);
  if (options.memory_layers > 0.0) keep_ = 1.0 - 1.0 / options.memory_layers;
  const auto scale = scales(options.prior);
  for (int n = 0; n < 3; ++n) {
    const double std_mm = options.prior_std * scale[std::size_t(n)];
    prior_information_.at(n, n) = 1.0 / (std_mm * std_mm);
  }
  estimate_.model = model_;
  estimate_.covariance_mm2 = inverse(prior_information_);
}

DropletEstimator::~DropletEstimator() = default;

void DropletEstimator::believe_height(double layer_height_mm, double std_mm) {
  estimator_needs(layer_height_mm > 0.0 && std_mm > 0.0, "a seen height or its deviation is not above 0");
  seen_height_mm_ = layer_height_mm;
  seen_information_ = 1.0 / (std_mm * std_mm);
  if (layers_ > 0) return;
  Symmetric3 information = prior_information_;
  add_seen(information);
  estimate_.covariance_mm2 = inverse(information);
  const std::array<double, 3> prior = values(options_.prior),
                              gain = estimate_.covariance_mm2.times(kLayerHeight);
  const double off = seen_height_mm_ - options_.prior.layer_height_mm();
  std::array<double, 3> h{};
  for (std::size_t n = 0; n < 3; ++n)
    h[n] = std::max(n == 0 ? 0.02 * prior[0] : 0.0, prior[n] + gain[n] * seen_information_ * off);
  estimate_.model = model_ = start_model_ = model_of(h.data());
}

void DropletEstimator::add_seen(Symmetric3& information) const {
  for (int r = 0; r < 3; ++r)
    for (int q = 0; q < 3; ++q)
      information.at(r, q) += seen_information_ * kLayerHeight[std::size_t(r)] * kLayerHeight[std::size_t(q)];
}

// The noise reported with single maps jumps with the sensor's resolution. All maps are of one sensor.
void DropletEstimator::update_noise(double std_mm) {
  reported_variance_mm2_ += (std_mm * std_mm - reported_variance_mm2_) / double(++reports_);
}

void DropletEstimator::set_substrate(const HeightMap& height, const std::vector<Use>& use,
                                     double noise_std_mm) {
  check_map("droplet estimator", grid_, height, use, noise_std_mm);
  start_ = filter_.substrate(height.cells, use, noise_std_mm * noise_std_mm);
  const auto measured = std::count_if(use.begin(), use.end(), [](Use u) { return u != Use::kNothing; });
  estimator_needs(measured > 0, "the bare ground has no measured cell");
  double rough = 0.0;
  for (const double v : start_.variance_mm2) rough += v / double(start_.variance_mm2.size());
  substrate_variance_mm2_ = (noise_std_mm * noise_std_mm + rough) / double(measured);
  start_by_substrate_.assign(grid_.size(), 1.0);
  start_model_ = model_;
  for (auto& slope : start_slope_) slope.assign(grid_.size(), 0.0);
  substrate_.height_mm = height.cells;
  substrate_.use = use;
  update_noise(noise_std_mm);
  has_substrate_ = true;
}

Estimate DropletEstimator::add_layer(std::vector<Pass> passes, const HeightMap& height,
                                     const std::vector<Use>& use, double noise_std_mm) {
  keep_layer(std::move(passes), height, use, noise_std_mm);
  return update();
}

void DropletEstimator::keep_layer(std::vector<Pass> passes, const HeightMap& height,
                                  const std::vector<Use>& use, double noise_std_mm) {
  estimator_needs(has_substrate_, "a layer came before the map of the bare ground");
  check_map("droplet estimator", grid_, height, use, noise_std_mm);
  for (const Pass& p : passes) {
    estimator_needs(p.share > 0.0 && p.share <= 1.0, "the counted share of a pass is outside (0, 1]");
    for (const std::uint32_t c : p.cells) estimator_needs(c < grid_.size(), "a pass fires off the grid");
    droplets_ += std::int64_t(p.cells.size());
  }
  if (int(window_.size()) >= options_.window_layers) {
    if (waiting_ == int(window_.size())) update();  // the oldest layer leaves the window as it was estimated
    forget_oldest();
  }
  forget();
  Layer layer;
  layer.passes = std::move(passes);
  layer.height_mm = height.cells;
  layer.use = use;
  update_noise(noise_std_mm);
  window_.push_back(std::move(layer));
  ++layers_;
  ++waiting_;
}

Estimate DropletEstimator::look() {
  fix_references();
  update_fit();
  return estimate_;
}

// Exponential forgetting of the layers before the window, by one layer.
void DropletEstimator::forget() {
  if (keep_ == 1.0) return;
  for (CellTerms& t : old_) {
    for (double& v : t.information.m) v *= keep_;
    for (double& v : t.information_vector) v *= keep_;
  }
  for (double& v : information_.m) v *= keep_;
  for (double& v : information_vector_) v *= keep_;
  for (double& v : old_substrate_) v *= keep_;
}

double DropletEstimator::weight_of(std::size_t k) const {
  double weight = 1.0;
  if (keep_ != 1.0)
    for (std::size_t n = k + 1; n < window_.size(); ++n) weight *= keep_;
  return weight;
}

Estimate DropletEstimator::replace_map(const HeightMap& height, const std::vector<Use>& use,
                                       double noise_std_mm) {
  check_map("droplet estimator", grid_, height, use, noise_std_mm);
  if (window_.empty()) {
    estimator_needs(layers_ == 0, "there is no layer whose map could be replaced");
    set_substrate(height, use, noise_std_mm);
    return estimate_;
  }
  window_.back().height_mm = height.cells;
  window_.back().use = use;
  update_noise(noise_std_mm);
  return update();
}

// Repeated while the estimate is far from the one that fixed the gains and weights.
Estimate DropletEstimator::update() {
  evaluations_ = 0;
  const auto scale = scales(options_.prior);
  for (int round = 0; round < kMaxRounds; ++round) {
    const DropletModel before = model_;
    fix_references();
    minimise();
    fit_scatter();
    if (std::abs(model_.h1_mm - before.h1_mm) < kSettled * scale[0] &&
        std::abs(model_.h2_mm - before.h2_mm) < kSettled * scale[1] &&
        std::abs(model_.h3_mm - before.h3_mm) < kSettled * scale[2])
      break;
  }
  fix_references();
  update_fit();
  waiting_ = 0;
  return estimate_;
}

// The surface before the window, had the layers before it been filtered with `m`: to first order.
void DropletEstimator::start_at(const DropletModel& m, double substrate_shift_mm,
                                std::vector<double>& height_mm) const {
  height_mm = start_.height_mm;
  const double d1 = m.h1_mm - start_model_.h1_mm, d2 = m.h2_mm - start_model_.h2_mm,
               d3 = m.h3_mm - start_model_.h3_mm;
  if (d1 == 0.0 && d2 == 0.0 && d3 == 0.0 && substrate_shift_mm == 0.0) return;
  for (std::size_t c = 0; c < height_mm.size(); ++c)
    height_mm[c] += start_slope_[0][c] * d1 + start_slope_[1][c] * d2 + start_slope_[2][c] * d3 +
                    start_by_substrate_[c] * substrate_shift_mm;
}

void DropletEstimator::fix_references() {
  if (layers_ == int(window_.size()))
    start_ = filter_.substrate(substrate_.height_mm, substrate_.use, noise_variance_mm2());
  Surface s{{}, start_.variance_mm2};
  start_at(model_, 0.0, s.height_mm);
  for (Layer& l : window_) {
    l.noise_variance_mm2 = noise_variance_mm2();
    filter_.reference(l, s, model_, scatter_);
  }
}

void DropletEstimator::differences_at(const DropletModel& m, double substrate_shift_mm,
                                      std::vector<std::vector<double>>& out) {
  out.resize(window_.size());
  start_at(m, substrate_shift_mm, work_->height);
  for (std::size_t k = 0; k < window_.size(); ++k) {
    out[k].resize(grid_.size());
    filter_.differences(window_[k], work_->height, m, scatter_, out[k]);
  }
}

// Relative scatter of droplets and the scale of the maps' noise by moments: the excess of the squared
// differences over the surface's own variance, in the weighting that is optimal for normal ones. (Estimated
// from differences of neighbouring samples, a map's noise includes steps of the surface.)
void DropletEstimator::fit_scatter() {
  differences_at(model_, 0.0, work_->at_best);
  double gg = 0.0, gr = 0.0, rr = 0.0, ge = 0.0, re = 0.0;
  for (std::size_t k = 0; k < window_.size(); ++k) {
    const Layer& l = window_[k];
    const double r = reported_variance_mm2_;
    for (std::size_t c = 0; c < grid_.size(); ++c) {
      if (l.weight[c] == 0.0) continue;
      const double e = clipped(work_->at_best[k][c], l.weight[c]), g = l.scatter_mm2[c],
                   w2 = l.weight[c] * l.weight[c];
      const double beyond_surface =
          e * e / kClippedSquare - 1.0 / l.weight[c] + scatter_ * scatter_ * g + noise_scale_ * r;
      gg += w2 * g * g;
      gr += w2 * g * r;
      rr += w2 * r * r;
      ge += w2 * g * beyond_surface;
      re += w2 * r * beyond_surface;
    }
  }
  const double det = gg * rr - gr * gr;
  if (!(det > 1e-6 * gg * rr)) return;
  double scatter2 = (ge * rr - re * gr) / det, noise = (re * gg - ge * gr) / det;
  if (scatter2 < 0.0) {
    scatter2 = 0.0;
    noise = re / rr;
  }
  scatter_ = std::min(kMaxScatter, std::sqrt(scatter2));
  noise_scale_ = std::clamp(noise, kMinNoiseScale, 1.0 / kMinNoiseScale);
}

double DropletEstimator::objective(const double* h) {
  ++evaluations_;
  const DropletModel m = model_of(h);
  start_at(m, 0.0, work_->height);
  work_->difference.resize(grid_.size());
  double sum = 0.0;
  for (std::size_t k = 0; k < window_.size(); ++k) {
    const Layer& l = window_[k];
    filter_.differences(l, work_->height, m, scatter_, work_->difference);
    const double fading = weight_of(k);
    for (std::size_t c = 0; c < grid_.size(); ++c) sum += fading * loss(work_->difference[c], l.weight[c]);
  }
  const std::array<double, 3> at{h[0], h[1], h[2]}, prior = values(options_.prior);
  const std::array<double, 3> off{h[0] - prior[0], h[1] - prior[1], h[2] - prior[2]};
  const double unseen = m.layer_height_mm() - seen_height_mm_;
  return 0.5 * (sum + information_.form(at) + prior_information_.form(off) +
                seen_information_ * unseen * unseen) -
         information_vector_[0] * h[0] - information_vector_[1] * h[1] - information_vector_[2] * h[2];
}

void DropletEstimator::minimise() {
  const auto scale = scales(options_.prior);
  std::array<double, 3> low{0.02 * scale[0], 0.0, 0.0},
      high{50.0 * scale[0], 50.0 * scale[0], 50.0 * scale[0]};
  std::array<double, 3> h = values(model_), step{};
  for (std::size_t n = 0; n < 3; ++n) {
    h[n] = std::clamp(h[n], low[n], high[n]);
    step[n] = std::clamp(3.0 * estimate_.std_mm(int(n)), 1e-3 * scale[n], 0.3 * scale[n]);
  }
  const auto call = [](unsigned, const double* x, double*, void* self) {
    return static_cast<DropletEstimator*>(self)->objective(x);
  };
  nlopt_opt opt = nlopt_create(NLOPT_LN_BOBYQA, 3);
  nlopt_set_lower_bounds(opt, low.data());
  nlopt_set_upper_bounds(opt, high.data());
  nlopt_set_initial_step(opt, step.data());
  nlopt_set_min_objective(opt, call, this);
  nlopt_set_xtol_rel(opt, 1e-6);
  nlopt_set_maxeval(opt, options_.max_evaluations);
  double value = 0.0;
  nlopt_optimize(opt, h.data(), &value);
  nlopt_destroy(opt);
  for (std::size_t n = 0; n < 3; ++n)
    at_bound_[n] = h[n] - low[n] <= kAtBound * scale[n] || high[n] - h[n] <= kAtBound * high[n];
  model_ = model_of(h.data());
}

void DropletEstimator::update_fit() {
  Work& w = *work_;
  const auto at = values(model_);
  const auto scale = scales(model_);
  differences_at(model_, 0.0, w.at_best);
  std::vector<std::vector<double>> other;
  for (int n = 0; n < 3; ++n) {
    auto h = at;
    const double up = kStep * scale[std::size_t(n)], down = std::min(up, h[std::size_t(n)]);
    h[std::size_t(n)] = at[std::size_t(n)] + up;
    differences_at(model_of(h.data()), 0.0, w.slope[std::size_t(n)]);
    h[std::size_t(n)] = at[std::size_t(n)] - down;
    differences_at(model_of(h.data()), 0.0, other);
    for (std::size_t k = 0; k < window_.size(); ++k)
      for (std::size_t c = 0; c < grid_.size(); ++c)
        w.slope[std::size_t(n)][k][c] = (other[k][c] - w.slope[std::size_t(n)][k][c]) / (up + down);
  }
  w.cell.assign(grid_.size(), {});
  for (std::size_t c = 0; c < grid_.size(); ++c) w.cell[c] = old_[c];
  double squares = 0.0, count = 0.0;
  for (std::size_t k = 0; k < window_.size(); ++k) squares += add_layer_terms(k, w.cell, count);
  Symmetric3 information, spread;
  std::vector<std::array<double, 3>> score(grid_.size());
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    information += w.cell[c].information;
    const auto known = w.cell[c].information.times(at);
    for (std::size_t r = 0; r < 3; ++r) score[c][r] = w.cell[c].information_vector[r] - known[r];
  }
  for (int j = 0; j < grid_.ny; ++j)
    for (int i = 0; i < grid_.nx; ++i) {
      std::array<double, 3> near{};
      for (int y = std::max(0, j - kReach); y <= std::min(grid_.ny - 1, j + kReach); ++y)
        for (int x = std::max(0, i - kReach); x <= std::min(grid_.nx - 1, i + kReach); ++x)
          for (std::size_t r = 0; r < 3; ++r) near[r] += score[grid_.index(x, y)][r];
      const auto& own = score[grid_.index(i, j)];
      for (int r = 0; r < 3; ++r)
        for (int q = 0; q < 3; ++q)
          spread.at(r, q) +=
              0.5 * (own[std::size_t(r)] * near[std::size_t(q)] + own[std::size_t(q)] * near[std::size_t(r)]);
    }
  estimate_.excitation = separation(information);
  estimate_.information = information;
  estimate_.fit = count > 0.0 ? squares / count : 0.0;
  // With too few cells the sum over neighbours need not be a covariance; the assumed variances stand in.
  if (!positive_definite(spread)) {
    spread = information;
    for (double& v : spread.m) v *= std::max(1.0, estimate_.fit);
  }
  // The substrate's mean height errs by the same amount in all cells, so their scores do not show it.
  differences_at(model_, kGroundShift_mm, other);
  std::array<double, 3> by_substrate = old_substrate_;
  for (std::size_t k = 0; k < window_.size(); ++k) add_substrate_terms(k, other[k], by_substrate);
  information += prior_information_;
  spread += prior_information_;
  add_seen(information);
  add_seen(spread);
  for (int r = 0; r < 3; ++r)
    for (int q = 0; q < 3; ++q)
      spread.at(r, q) +=
          substrate_variance_mm2_ * by_substrate[std::size_t(r)] * by_substrate[std::size_t(q)];
  estimate_.model = model_;
  estimate_.covariance_mm2 = sandwich(inverse(information), spread);
  estimate_.droplet_scatter = scatter_;
  estimate_.scatter_at_bound = scatter_ >= kMaxScatter;
  estimate_.at_bound = at_bound_;
  for (int n = 0; n < 3; ++n)
    estimate_.prior_share[std::size_t(n)] = estimate_.covariance_mm2.at(n, n) * prior_information_.at(n, n);
  estimate_.layers = layers_;
  estimate_.droplets = droplets_;
  estimate_.evaluations = evaluations_;
}

// Information of layer k of the window, cell by cell, about the model of the last update_fit().
double DropletEstimator::add_layer_terms(std::size_t k, std::vector<CellTerms>& terms, double& count) const {
  const Layer& l = window_[k];
  const auto at = values(model_);
  const double fading = weight_of(k);
  double squares = 0.0;
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    if (l.weight[c] == 0.0) continue;
    const bool out = beyond(work_->at_best[k][c], l.weight[c]);
    const double e = clipped(work_->at_best[k][c], l.weight[c]);
    if (l.scatter_mm2[c] > 0.0) {
      squares += l.weight[c] * e * e;
      count += 1.0;
    }
    Symmetric3 information;
    for (std::size_t r = 0; r < 3 && !out; ++r)
      for (std::size_t q = 0; q < 3; ++q)
        information.at(int(r), int(q)) = fading * work_->slope[r][k][c] * l.weight[c] * work_->slope[q][k][c];
    const auto known = information.times(at);
    for (std::size_t r = 0; r < 3; ++r)
      terms[c].information_vector[r] += fading * work_->slope[r][k][c] * l.weight[c] * e + known[r];
    terms[c].information += information;
  }
  return squares;
}

void DropletEstimator::add_substrate_terms(std::size_t k, const std::vector<double>& shifted,
                                           std::array<double, 3>& sum) const {
  const double fading = weight_of(k);
  for (std::size_t c = 0; c < grid_.size(); ++c)
    for (std::size_t r = 0; r < 3; ++r)
      sum[r] += fading * work_->slope[r][k][c] * window_[k].weight[c] * (shifted[c] - work_->at_best[k][c]) /
                kGroundShift_mm;
}

// The surface after the oldest layer becomes the start, and its derivatives with it, so that the information
// of the layer in later ones is kept.
void DropletEstimator::forget_oldest() {
  Layer& oldest = window_.front();
  double count = 0.0;
  add_layer_terms(0, old_, count);
  Work& w = *work_;
  w.difference.resize(grid_.size());
  const auto after = [&](const DropletModel& m, double substrate_shift_mm) {
    start_at(m, substrate_shift_mm, w.height);
    filter_.differences(oldest, w.height, m, scatter_, w.difference);
    return w.height;
  };
  const std::vector<double> shifted = after(model_, kGroundShift_mm);
  add_substrate_terms(0, w.difference, old_substrate_);
  const std::vector<double> height = after(model_, 0.0);
  const auto scale = scales(model_);
  std::array<std::vector<double>, 3> slope;
  for (std::size_t n = 0; n < 3; ++n) {
    auto h = values(model_);
    h[n] += kStep * scale[n];
    slope[n] = after(model_of(h.data()), 0.0);
    for (std::size_t c = 0; c < grid_.size(); ++c)
      slope[n][c] = keep_ * ((slope[n][c] - height[c]) / (kStep * scale[n]));
  }
  for (std::size_t c = 0; c < grid_.size(); ++c)
    start_by_substrate_[c] = (shifted[c] - height[c]) / kGroundShift_mm;
  Surface s{{}, start_.variance_mm2};
  start_at(model_, 0.0, s.height_mm);
  filter_.reference(oldest, s, model_, scatter_);
  start_ = {height, s.variance_mm2};
  start_slope_ = std::move(slope);
  start_model_ = model_;
  information_ = {};
  information_vector_ = {};
  for (const CellTerms& t : old_) {
    information_ += t.information;
    for (std::size_t r = 0; r < 3; ++r) information_vector_[r] += t.information_vector[r];
  }
  window_.erase(window_.begin());
  w.at_best.erase(w.at_best.begin());
  for (auto& by_layer : w.slope) by_layer.erase(by_layer.begin());
}

}  // namespace firn::droplet
