#include "core/control/stall_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/control/prediction.h"

namespace firn::control {

StallBound::StallBound(std::unique_ptr<LayerController> inner, const Setup& setup,
                       const ControlOptions& options)
    : inner_(std::move(inner)),
      target_(setup.target),
      mask_(setup.mask),
      cells_(double(setup.mask.count())),
      layers_(options.stall_layers),
      offset_mm_(options.target_offset_mm) {}

void StallBound::use_options(const ControlOptions& options) {
  inner_->use_options(options);
  layers_ = options.stall_layers;
  if (std::exchange(offset_mm_, options.target_offset_mm) != options.target_offset_mm) quality_.clear();
}

void StallBound::remember(const Measurement& m) {
  while (!quality_.empty() && quality_.back().layer >= m.layer) quality_.pop_back();
  Quality q{m.layer, 0.0, 0.0};
  for (std::size_t c = 0; c < mask_.size(); ++c) {
    if (!mask_.cells[c]) continue;
    const double error = target_.cells[c] - m.height.cells[c];
    q.mean_mm += std::abs(error);
    q.rms_mm += error * error;
  }
  q.mean_mm /= cells_;
  q.rms_mm = std::sqrt(q.rms_mm / cells_);
  quality_.push_back(q);
}

bool StallBound::stalled(double noise_std_mm) const {
  if (layers_ == 0) return false;
  const Quality now = quality_.back();
  double mean_mm = std::numeric_limits<double>::infinity(), rms_mm = mean_mm;
  for (const Quality& q : quality_)
    if (q.layer <= now.layer - layers_) {
      mean_mm = std::min(mean_mm, q.mean_mm);
      rms_mm = std::min(rms_mm, q.rms_mm);
    }
  if (!std::isfinite(mean_mm)) return false;
  const double noise_mm = kSigmas * noise_std_mm * std::sqrt(2.0 / cells_);
  return mean_mm - now.mean_mm <= noise_mm && rms_mm - now.rms_mm <= noise_mm;
}

Decision StallBound::decide(const Measurement& m) {
  Decision d = inner_->decide(m);  // which also checks the measurement
  remember(m);
  if (d.kind == Decision::Kind::kPrint && stalled(m.noise_std_mm))
    end_print(d, "the last " + std::to_string(layers_) +
                     " layers have bettered the part by no more than the "
                     "noise of its measurement");
  return d;
}

}  // namespace firn::control
