#include "procs/controller/height_estimate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "lcmtypes/convert.h"

namespace firn {
namespace {

// A map that tells no noise has less than the sensor's resolution shows.
constexpr double kLeastNoise_mm = 1e-4;

droplet::HeightFilterOptions options_of(const Experiment& e) {
  return {{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm},
          e.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose,
          e.control.droplet_scatter};
}

}  // namespace

HeightEstimate::HeightEstimate(const Experiment& e, Mask mask)
    : mask_(std::move(mask)), grid_(e.grid), filter_(e.grid, options_of(e)) {
  if (mask_.size() != grid_.size()) throw std::invalid_argument("height estimate: the mask does not have the grid's size");
}

void HeightEstimate::take(const deposition_report_t& r) {
  if (from_message(r.grid) != grid_ || r.drops.size() != grid_.size() || r.layer < layer_ || r.layer <= taken_) return;
  if (r.layer > layer_) {
    layer_ = r.layer;
    drops_ = {};
  }
  drops_.add({drops_of(r), r.pass, r.passes, r.triggered_jet, r.unknown_from, r.unknown_to});
}

void HeightEstimate::use_model(const deposition::DropletModel& model, double droplet_scatter) {
  filter_.use_model(model, droplet_scatter);
}

bool HeightEstimate::ready(const height_map_t& m) const {
  return m.layer == 0 || m.layer <= taken_ || (m.layer == layer_ && drops_.complete());
}

void HeightEstimate::take(const height_map_t& m) {
  if (m.layer < taken_) throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": layer " + std::to_string(m.layer) +
                                                    " came after layer " + std::to_string(taken_));
  if (m.quality.size() != grid_.size()) throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": no quality of each cell");
  const HeightMap height = height_of(m);
  const double noise = std::isfinite(m.noise_std_mm) ? std::max(m.noise_std_mm, kLeastNoise_mm) : kLeastNoise_mm;
  const droplet::LayerDrops drops = m.layer == layer_ ? drops_ : droplet::LayerDrops{};
  const auto use = drops.use_of(height, m.quality, mask_);
  if (m.layer == taken_)
    filter_.replace_map(height, use, noise);
  else if (!filter_.has_ground())
    filter_.set_ground(height, use, noise);
  else if (m.layer == taken_ + 1 && m.layer == layer_ && drops_.complete())
    filter_.add_layer(drops.passes(), height, use, noise);
  else
    filter_.start_anew(height, use, noise);
  taken_ = m.layer;
}

HeightMap HeightEstimate::height() const {
  HeightMap h(grid_);
  h.cells = filter_.surface().height_mm;
  return h;
}

}  // namespace firn
