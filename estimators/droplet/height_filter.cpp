#include "estimators/droplet/height_filter.h"

#include <cmath>
#include <string>
#include <utility>

#include "core/options/require.h"

namespace firn::droplet {
namespace {

void filter_needs(bool ok, std::string_view what) { firn::require(ok, "height filter", what); }

}  // namespace

HeightFilter::HeightFilter(const GridSpec& grid, const HeightFilterOptions& options)
    : grid_(grid), options_(options), filter_(grid, options.border) {
  firn::check(grid);
  check_options("height filter", OptionTable{kDropletScatter}, options);
  use_model(options.model, options.droplet_scatter);
}

void HeightFilter::use_model(const deposition::DropletModel& model, double droplet_scatter) {
  deposition::check(model);
  filter_needs(std::isfinite(droplet_scatter) && droplet_scatter >= 0.0,
               "droplet_scatter = " + std::to_string(droplet_scatter) + " must not be below 0");
  options_.model = model;
  options_.droplet_scatter = droplet_scatter;
}

void HeightFilter::update_noise(double std_mm) {
  noise_variance_mm2_ += (std_mm * std_mm - noise_variance_mm2_) / double(++reports_);
}

void HeightFilter::set_substrate(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm) {
  check_map("height filter", grid_, height, use, noise_std_mm);
  update_noise(noise_std_mm);
  surface_ = filter_.substrate(height.cells, use, noise_variance_mm2_);
  has_substrate_ = on_substrate_ = true;
}

void HeightFilter::add_layer(std::vector<Pass> passes, const HeightMap& height, const std::vector<Use>& use,
                             double noise_std_mm) {
  filter_needs(has_substrate_, "a layer came before the map of the bare ground");
  check_map("height filter", grid_, height, use, noise_std_mm);
  for (const Pass& p : passes) {
    filter_needs(p.share > 0.0 && p.share <= 1.0, "the counted share of a pass is outside (0, 1]");
    for (const std::uint32_t c : p.cells) filter_needs(c < grid_.size(), "a pass fires off the grid");
  }
  update_noise(noise_std_mm);
  Layer layer;
  layer.passes = std::move(passes);
  predicted_ = surface_;
  filter_.predict(layer, predicted_, options_.model, options_.droplet_scatter);
  on_substrate_ = false;
  correct(height, use);
}

void HeightFilter::replace_map(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm) {
  filter_needs(has_substrate_, "there is no map that could be replaced");
  if (on_substrate_) return set_substrate(height, use, noise_std_mm);
  check_map("height filter", grid_, height, use, noise_std_mm);
  update_noise(noise_std_mm);
  correct(height, use);
}

void HeightFilter::start_anew(const HeightMap& height, const std::vector<Use>& use, double noise_std_mm) {
  std::vector<Use> anchored = use;
  for (Use& u : anchored)
    if (u == Use::kLearn) u = Use::kAnchor;
  if (!has_substrate_) return set_substrate(height, use, noise_std_mm);
  add_layer({}, height, anchored, noise_std_mm);
}

void HeightFilter::correct(const HeightMap& height, const std::vector<Use>& use) {
  const double r = noise_variance_mm2_;
  surface_ = predicted_;
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    if (use[c] == Use::kNothing) continue;
    const double p = predicted_.variance_mm2[c], e = height.cells[c] - predicted_.height_mm[c];
    const bool anchored = use[c] == Use::kAnchor || e * e > kOutlier * kOutlier * (p + r);
    const double gain = anchored ? 1.0 : p / (p + r);
    surface_.height_mm[c] = anchored ? height.cells[c] : predicted_.height_mm[c] + gain * e;
    surface_.variance_mm2[c] = anchored ? r : (1.0 - gain) * p;
  }
}

double HeightFilter::std_mm(const Mask& mask) const {
  double sum = 0.0, n = 0.0;
  for (std::size_t c = 0; c < grid_.size(); ++c)
    if (mask.cells[c]) {
      sum += surface_.variance_mm2[c];
      n += 1.0;
    }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

}  // namespace firn::droplet
