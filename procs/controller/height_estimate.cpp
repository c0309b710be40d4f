#include "procs/controller/height_estimate.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "lcmtypes/convert.h"

namespace firn {
namespace {

// A map without a reported noise has less noise than the sensor's resolution.
constexpr double kMinNoise_mm = 1e-4;
constexpr double kSparseStd = 0.4;  // control.droplet_factors = "together"

droplet::HeightFilterOptions options_of(const Experiment& e) {
  return {{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm},
          e.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose,
          e.control.filter.droplet_scatter};
}

}  // namespace

HeightEstimate::HeightEstimate(const Experiment& e, Mask mask)
    : mask_(std::move(mask)),
      grid_(e.grid),
      model_(options_of(e).model),
      droplet_scatter_(e.control.filter.droplet_scatter),
      filter_(e.grid, options_of(e)) {
  if (mask_.size() != grid_.size())
    throw std::invalid_argument("height estimate: the mask does not have the grid's size");
  if (e.control.droplet_factors == "off") return;
  droplet::DropletFactorOptions o;
  o.model = model_;
  o.border = options_of(e).border;
  if (e.control.droplet_factors == "together") o.sparse_std = kSparseStd;
  factors_.emplace(grid_, mask_, o);
}

void HeightEstimate::take(const deposition_report_t& r) {
  if (from_message(r.grid) != grid_ || r.drops.size() != grid_.size() || r.layer < layer_ ||
      r.layer <= taken_)
    return;
  if (r.layer > layer_) {
    layer_ = r.layer;
    drops_ = {};
  }
  drops_.add({drops_of(r), r.pass_index, r.passes, r.triggered_jet, r.unknown_from, r.unknown_to});
}

void HeightEstimate::use_model(const deposition::DropletModel& model, double droplet_scatter) {
  filter_.use_model(model, droplet_scatter);
}

// Returns the layer's passes, after the update of the droplet factors: separately by place, since the shares
// differ.
std::vector<droplet::Pass> HeightEstimate::learned_from(const HeightMap& height,
                                                        const std::vector<droplet::Use>& use) {
  std::vector<droplet::Pass> passes = drops_.passes();
  if (!factors_) return passes;
  factors_->add_layer(filter_.surface().height_mm, passes, height.cells, use);
  const double inside = factors_->at(droplet::Place::kInside);
  filter_.use_model(model_.times(inside), droplet_scatter_);
  std::vector<droplet::Pass> apart;
  for (const droplet::Pass& pass : passes)
    for (const droplet::Place place :
         {droplet::Place::kInside, droplet::Place::kBetween, droplet::Place::kRim}) {
      droplet::Pass there{{}, pass.share * std::min(1.0, factors_->at(place) / inside)};
      for (const std::uint32_t c : pass.cells)
        if (factors_->places().cells[c] == place) there.cells.push_back(c);
      if (!there.cells.empty()) apart.push_back(std::move(there));
    }
  return apart;
}

bool HeightEstimate::ready(const height_map_t& m) const {
  return m.layer == 0 || m.layer <= taken_ || (m.layer == layer_ && drops_.complete());
}

void HeightEstimate::take(const height_map_t& m) {
  if (m.layer < taken_)
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": layer " +
                                std::to_string(m.layer) + " came after layer " + std::to_string(taken_));
  if (m.quality.size() != grid_.size())
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": no quality of each cell");
  const HeightMap height = height_of(m);
  const double noise = std::isfinite(m.noise_std_mm) ? std::max(m.noise_std_mm, kMinNoise_mm) : kMinNoise_mm;
  const droplet::LayerDrops drops = m.layer == layer_ ? drops_ : droplet::LayerDrops{};
  const auto use = drops.use_of(height, m.quality, mask_);
  if (m.layer == taken_)
    filter_.replace_map(height, use, noise);
  else if (!filter_.has_substrate())
    filter_.set_substrate(height, use, noise);
  else if (m.layer == taken_ + 1 && m.layer == layer_ && drops_.complete())
    filter_.add_layer(learned_from(height, use), height, use, noise);
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
