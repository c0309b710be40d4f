#include "core/control/prediction.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace firn::control {

double objective_mm(const HeightMap& height, const HeightMap& target, const Mask& mask, double alpha) {
  double n = 0.0, sum = 0.0, sum_abs = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask.cells[c]) continue;
    n += 1.0;
    sum += height.cells[c] - target.cells[c];
    sum_abs += std::abs(target.cells[c] - height.cells[c]);
  }
  if (n == 0.0) return 0.0;
  const double mean = sum / n;
  double square = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c) {
    if (!mask.cells[c]) continue;
    const double d = height.cells[c] - target.cells[c] - mean;
    square += d * d;
  }
  return alpha * (sum_abs / n) + (1.0 - alpha) * std::sqrt(square / n);
}

bool beats_noise(const Decision& d, std::int64_t part_cells, double noise_std_mm, double gate,
                 ErrorKind error) {
  const double none = d.objective_none_mm, with = d.objective_mm;
  const bool square = error == ErrorKind::kSquare;
  const double better = square ? none * none - with * with : none - with;
  const double noise = square ? noise_std_mm * noise_std_mm : noise_std_mm;
  return better > 0.0 && better * double(part_cells) > gate * noise * double(d.drops.total());
}

void end_print(Decision& d, std::string reason) {
  d.kind = Decision::Kind::kEnd;
  std::fill(d.drops.cells.begin(), d.drops.cells.end(), std::uint8_t{0});
  d.offsets = {};
  d.objective_mm = d.objective_none_mm;
  d.reason = std::move(reason);
}

Predictor::Predictor(const Setup& s)
    : target_(s.target),
      mask_(s.mask),
      model_(s.grid, deposition::stencil_of(s.model), s.border),
      two_inks_(s.grid, {s.model, s.model_b}, s.border),
      offsets_(s.grid, s.offsets, s.border, s.offsets_b) {}

HeightMap Predictor::after(const HeightMap& height, const DropletPattern& drops, const MaterialMap& materials,
                           const OffsetMap& offsets) {
  HeightMap h = height;
  if (offsets.size() != 0)
    offsets_.deposit(h, drops, offsets, materials);
  else if (materials.size() != 0)
    two_inks_.deposit(h, drops, materials);
  else
    model_.deposit(h, drops);
  return h;
}

void Predictor::score(Decision& d, const HeightMap& height, double alpha) {
  d.objective_none_mm = objective_mm(height, target_, mask_, alpha);
  d.objective_mm = d.drops.passes()
                       ? objective_mm(after(height, d.drops, d.materials, d.offsets), target_, mask_, alpha)
                       : d.objective_none_mm;
}

}  // namespace firn::control
