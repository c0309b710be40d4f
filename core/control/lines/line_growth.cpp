#include "core/control/lines/line_growth.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::control {
namespace {

constexpr double kCommonError = 0.003;  // of the seen ink, alike in all pictures of a layer: light, focus

}  // namespace

void LineGrowth::plan(std::int32_t layer, std::vector<double> section_mm2) {
  planned_layer_ = layer;
  planned_mm2_ = std::move(section_mm2);
}

GrowthShare LineGrowth::look(std::int32_t layer, std::span<const SeenLine> seen) {
  if (layer != newest_layer_) {
    if (resolved_ || reference_.seen.empty()) reference_ = newest_;
    newest_.planned_mm2.resize(seen.size());
    if (layer == planned_layer_)
      for (std::size_t s = 0; s < std::min(seen.size(), planned_mm2_.size()); ++s)
        newest_.planned_mm2[s] += planned_mm2_[s];
    newest_layer_ = layer;
  }
  newest_.seen.assign(seen.begin(), seen.end());
  const GrowthShare g = growth();
  resolved_ = g.resolved();
  return g;
}

GrowthShare LineGrowth::growth() const {
  const auto expected_ink = [&](const Look& l, std::size_t s) {
    return visible_.contrast(l.planned_mm2[s]) * visible_.width_mm(l.planned_mm2[s]);
  };
  double grown = 0.0, expected = 0.0, variance = 0.0, count = 0.0;
  for (std::size_t s = 0; s < std::min(reference_.seen.size(), newest_.seen.size()); ++s) {
    const SeenLine &a = reference_.seen[s], &b = newest_.seen[s];
    const double ratio = b.contrast * b.width_mm / (a.contrast * a.width_mm);
    const double a_std = a.width_std_mm / a.width_mm, b_std = b.width_std_mm / b.width_mm;
    const double ratio_variance = a_std * a_std + b_std * b_std;
    const double before = expected_ink(reference_, s);
    if (!std::isfinite(ratio) || !std::isfinite(ratio_variance) || !(before > 0.0)) continue;
    grown += ratio - 1.0;
    expected += expected_ink(newest_, s) / before - 1.0;
    variance += ratio_variance;
    count += 1.0;
  }
  if (!(expected > 0.0)) return {};
  return {grown / expected, std::sqrt(variance + kCommonError * kCommonError * count * count) / expected};
}

}  // namespace firn::control
