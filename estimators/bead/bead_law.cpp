#include "estimators/bead/bead_law.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "core/statistics/distributions.h"

namespace firn::bead {
namespace {

struct Score {
  double slope = 0.0, level = 0.0;
};

// Variances of slope and level from the sums of the clusters' scores. @param sxx of the centred ln v
template <class Key>
Score variance_of(const std::map<Key, Score>& clusters, double sxx, double n) {
  Score v;
  if (clusters.size() < 2) return v;
  for (const auto& [key, s] : clusters) {
    v.slope += s.slope * s.slope;
    v.level += s.level * s.level;
  }
  const double few = double(clusters.size()) / double(clusters.size() - 1);
  v.slope *= few / (sxx * sxx);
  v.level *= few / (n * n);
  return v;
}

}  // namespace

double BeadLaw::height_mm(double speed_mm_s) const { return std::exp(a * std::log(speed_mm_s) + b); }

BeadFit fit_bead_law(std::span<const Bead> beads) {
  if (beads.size() < 3)
    throw std::invalid_argument(std::to_string(beads.size()) + " beads; three are needed");
  BeadFit f;
  f.beads = std::int64_t(beads.size());
  const double n = double(beads.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (const Bead& b : beads) {
    if (!(b.speed_mm_s > 0.0 && b.height_mm > 0.0))
      throw std::invalid_argument("a bead's speed or height is not above 0");
    mean_x += std::log(b.speed_mm_s) / n;
    mean_y += std::log(b.height_mm) / n;
  }
  double sxx = 0.0, sxy = 0.0;
  for (const Bead& b : beads) {
    const double x = std::log(b.speed_mm_s) - mean_x;
    sxx += x * x;
    sxy += x * (std::log(b.height_mm) - mean_y);
  }
  f.reference_mm_s = std::exp(mean_x);
  f.speed_spread = std::sqrt(sxx / n);
  f.law.a = sxx > 0.0 ? sxy / sxx : 0.0;
  f.law.b = mean_y - f.law.a * mean_x;
  std::map<int, Score> layers;
  std::map<std::uint32_t, Score> segments;
  double squares = 0.0;
  for (const Bead& b : beads) {
    const double x = std::log(b.speed_mm_s) - mean_x, e = std::log(b.height_mm) - mean_y - f.law.a * x;
    squares += e * e;
    for (Score* s : {&layers[b.layer], &segments[b.segment]}) {
      s->slope += x * e;
      s->level += e;
    }
  }
  f.layers = int(layers.size());
  f.segments = int(segments.size());
  f.scatter = std::sqrt(squares / (n - 2.0));
  if (!(sxx > 0.0)) return f;
  const Score by_layer = variance_of(layers, sxx, n), by_segment = variance_of(segments, sxx, n);
  std::size_t clusters = layers.size();
  if (segments.size() > 1) clusters = std::min(clusters, segments.size());
  if (layers.size() < 2) clusters = segments.size();
  if (clusters < 2) return f;
  const double t = statistics::student_t_95(double(clusters - 1));
  const double slope = by_layer.slope + by_segment.slope, level = by_layer.level + by_segment.level;
  f.a_half_width = t * std::sqrt(slope);
  f.height_half_width = t * std::sqrt(level);
  f.b_half_width = t * std::sqrt(level + slope * mean_x * mean_x);
  return f;
}

BeadEstimator::BeadEstimator(const BeadLaw& start, double initial_p, double forgetting)
    : law_(start), forgetting_(forgetting), p_{initial_p, 0.0, initial_p} {}

void BeadEstimator::add(double speed_mm_s, double height_mm) {
  const double x = std::log(speed_mm_s), y = std::log(height_mm);
  const double px = p_[0] * x + p_[1], p1 = p_[1] * x + p_[2];
  const double k_a = px / (forgetting_ + x * px + p1), k_b = p1 / (forgetting_ + x * px + p1);
  const double e = y - (law_.a * x + law_.b);
  law_.a += k_a * e;
  law_.b += k_b * e;
  p_ = {(p_[0] - k_a * px) / forgetting_, (p_[1] - k_a * p1) / forgetting_, (p_[2] - k_b * p1) / forgetting_};
}

}  // namespace firn::bead
