#include "core/control/auto/lab_signs.h"

#include <algorithm>

#include "core/control/graph/graph_layer.h"
#include "core/control/prediction.h"

namespace firn::control {
namespace {

// Mean square of `rise` about `predicted`, at the scale that fits best.
double missed_mm2(const std::vector<double>& rise, const std::vector<double>& predicted) {
  double both = 0.0, own = 0.0, left = 0.0;
  for (std::size_t n = 0; n < rise.size(); ++n) {
    both += rise[n] * predicted[n];
    own += predicted[n] * predicted[n];
  }
  const double scale = own > 0.0 ? both / own : 0.0;
  for (std::size_t n = 0; n < rise.size(); ++n) {
    const double e = rise[n] - scale * predicted[n];
    left += e * e;
  }
  return left / double(rise.size());
}

}  // namespace

LayerSign sign_of_layer(const Setup& setup, const HeightMap& before, const DropletPattern& drops,
                        const MaterialMap& materials, const HeightMap& after, int layer, double noise_mm) {
  const auto on_mask = [&](const std::vector<double>& heights) {
    std::vector<double> rise;
    for (std::size_t c = 0; c < heights.size(); ++c)
      if (setup.mask.cells[c]) rise.push_back(heights[c] - before.cells[c]);
    return rise;
  };
  LayerSign s{layer, noise_mm};
  const std::vector<double> rise = on_mask(after.cells);
  double mean = 0.0, square = 0.0;
  for (const double r : rise) mean += r / double(rise.size());
  for (const double r : rise) square += (r - mean) * (r - mean) / double(rise.size());
  const double noise_mm2 = 2.0 * noise_mm * noise_mm;
  s.unlike_mm2 = std::max(0.0, square - noise_mm2);

  Predictor flow(setup);
  s.missed_mm2[std::size_t(JudgedModel::kFlow)] =
      missed_mm2(rise, on_mask(flow.after(before, drops, materials).cells));
  const graph::GraphModel graph(setup.model, setup.border, 1);
  std::vector<double> droplet_mm(setup.grid.size(), graph.droplet_mm), heights = before.cells,
                                                                       dose(setup.grid.size());
  for (std::size_t c = 0; c < dose.size(); ++c) {
    dose[c] = drops.cells[c];
    if (materials.size() != 0) droplet_mm[c] = setup.model_of(materials.of(c)).layer_height_mm();
  }
  graph::layer_along(graph, setup.grid, droplet_mm, heights, dose);
  s.missed_mm2[std::size_t(JudgedModel::kGraph)] = missed_mm2(rise, on_mask(heights));
  for (double& missed : s.missed_mm2) missed = std::max(0.0, missed - noise_mm2);
  return s;
}

void LabSigns::add(const LayerSign& sign) {
  layers_.push_back(sign);
  if (layers_.size() > std::size_t(kWindow)) layers_.erase(layers_.begin());
}

double LabSigns::noise_mm() const {
  double sum = 0.0;
  for (const LayerSign& s : layers_) sum += s.noise_mm / double(layers_.size());
  return sum;
}

bool LabSigns::tells(const LayerSign& s) const {
  const double least = kLeastUnlike * droplet_mm_;
  return s.unlike_mm2 > std::max(least * least, 2.0 * s.noise_mm * s.noise_mm);
}

int LabSigns::layers_judged() const {
  return int(std::ranges::count_if(layers_, [&](const LayerSign& s) { return tells(s); }));
}

double LabSigns::explained(JudgedModel model) const {
  double unlike = 0.0, missed = 0.0;
  for (const LayerSign& s : layers_) {
    if (!tells(s)) continue;
    unlike += s.unlike_mm2;
    missed += s.missed_mm2[std::size_t(model)];
  }
  return unlike > 0.0 ? 1.0 - missed / unlike : 0.0;
}

JudgedModel LabSigns::better_model() const {
  return explained(JudgedModel::kGraph) > explained(JudgedModel::kFlow) ? JudgedModel::kGraph
                                                                        : JudgedModel::kFlow;
}

}  // namespace firn::control
