#include "core/control/stall_detector.h"

#include <algorithm>
#include <cmath>

namespace firn::control {

void StallDetector::rewind(int layer) {
  while (!layers_.empty() && layers_.back().layer >= layer) layers_.pop_back();
}

void StallDetector::add(const Measurement& m, const HeightMap& target, const Mask& cells) {
  Quality q{m.layer};
  double n = 0.0;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (!cells.cells[c]) continue;
    const double error = target.cells[c] - m.height.cells[c];
    q.mean_mm += std::abs(error);
    q.rms_mm += error * error;
    n += 1.0;
  }
  q.mean_mm /= n;
  q.rms_mm = std::sqrt(q.rms_mm / n);
  q.noise_mm = kSigmas * m.noise_std_mm * std::sqrt(2.0 / n);
  layers_.push_back(q);
}

bool StallDetector::stalled(int n) const {
  if (n <= 0 || layers_.size() <= std::size_t(n)) return false;
  const Quality& now = layers_.back();
  Quality least = layers_.front();
  for (const Quality& q : std::span(layers_).first(layers_.size() - std::size_t(n))) {
    least.mean_mm = std::min(least.mean_mm, q.mean_mm);
    least.rms_mm = std::min(least.rms_mm, q.rms_mm);
  }
  return least.mean_mm - now.mean_mm <= now.noise_mm && least.rms_mm - now.rms_mm <= now.noise_mm;
}

}  // namespace firn::control
