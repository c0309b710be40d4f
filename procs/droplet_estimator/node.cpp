#include "procs/droplet_estimator/node.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/grid/firing_order.h"
#include "core/grid/npy.h"
#include "firn/fault_t.hpp"
#include "firn/height_model_t.hpp"
#include "lcmtypes/convert.h"
#include "lcmtypes/outcome.h"

namespace firn {
namespace {

constexpr double kLeastCountedShare = 0.9;  // below, the count itself is in doubt
constexpr double kNoiseIfUnknown_mm = 0.001;  // Lu 2015, V-B

droplet::EstimatorOptions options_of(const Experiment& e) {
  droplet::EstimatorOptions o;
  o.prior = {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm};
  o.prior_std = e.estimator.prior_std;
  o.window_layers = e.estimator.window_layers;
  o.border = e.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose;
  return o;
}

}  // namespace

void LayerDrops::add(const deposition_report_t& r) {
  DropletPattern commanded(from_message(r.grid));
  commanded.cells.assign(r.drops.begin(), r.drops.end());
  const auto order = firing_order(commanded, 0);
  const std::size_t n = order.size();
  const std::size_t known = std::min(n, std::size_t(r.unknown_from)), doubt_to = std::min(n, std::size_t(r.unknown_to));
  droplet::Pass pass;
  pass.cells.assign(order.begin(), order.begin() + std::ptrdiff_t(known));
  std::sort(pass.cells.begin(), pass.cells.end());
  std::size_t doubt_from = known, doubt_end = doubt_to;
  if (doubt_to == known && known == n && known > 0 && r.triggered_jet >= 0 && std::size_t(r.triggered_jet) < known) {
    pass.share = double(r.triggered_jet) / double(known);
    if (pass.share < kLeastCountedShare) doubt_from = 0, doubt_end = n;
  }
  for (std::size_t k = doubt_from; k < doubt_end; ++k) {
    doubt_.resize(commanded.size(), 0);
    const int i = int(order[k] % std::size_t(commanded.spec.nx)), j = int(order[k] / std::size_t(commanded.spec.nx));
    for (int y = j - 1; y <= j + 1; ++y)
      for (int x = i - 1; x <= i + 1; ++x)
        if (commanded.spec.contains(x, y)) doubt_[commanded.spec.index(x, y)] = 1;
  }
  if (doubt_from == 0 && doubt_end == n) pass.cells.clear(), pass.share = 1.0;
  if (!pass.cells.empty()) passes_.push_back(std::move(pass));
  // After a doubt the layer is closed; else its last pass, fired to its end, closes it.
  complete_ = doubt_to > known || (known == n && r.pass + 1 >= r.passes);
}

std::vector<droplet::Use> LayerDrops::use_of(const height_map_t& m, const Mask& mask) const {
  std::vector<droplet::Use> use(m.height_mm.size(), droplet::Use::kNothing);
  for (std::size_t c = 0; c < use.size(); ++c) {
    if (CellQuality(m.quality[c]) != CellQuality::kMeasured || !std::isfinite(m.height_mm[c])) continue;
    use[c] = !mask.cells[c] || (!doubt_.empty() && doubt_[c]) ? droplet::Use::kAnchor : droplet::Use::kLearn;
  }
  return use;
}

DropletEstimatorNode::DropletEstimatorNode(const Experiment& e, Mask mask)
    : grid_(e.grid), mask_(std::move(mask)), estimator_(e.grid, options_of(e)) {
  if (mask_.size() != grid_.size()) throw std::invalid_argument("droplet_estimator: the mask does not have the grid's size");
  subscribe(channels::kDepositionReport, this);
  subscribe(channels::kHeightMap, this);
}

void DropletEstimatorNode::on(const deposition_report_t& r, Time, Outbox& out) {
  if (from_message(r.grid) != grid_ || r.drops.size() != grid_.size())
    return warn("DEPOSITION_REPORT of layer " + std::to_string(r.layer) + ": its grid is not the experiment's", out);
  if (r.layer < layer_ || r.layer <= learned_) return;  // of a layer that has been taken in without it
  if (r.layer > layer_) {
    layer_ = r.layer;
    drops_ = {};
  }
  drops_.add(r);
  if (!waiting_ || waiting_->layer != layer_ || !drops_.complete()) return;
  const height_map_t map = std::move(*waiting_);
  waiting_.reset();
  learn(map, out);
}

void DropletEstimatorNode::on(const height_map_t& m, Time, Outbox& out) {
  if (from_message(m.grid) != grid_ || m.height_mm.size() != grid_.size() || m.quality.size() != grid_.size())
    return warn("HEIGHT_MAP " + std::to_string(m.map_id) + ": its grid is not the experiment's", out);
  if (waiting_) {
    const height_map_t map = std::move(*waiting_);
    waiting_.reset();
    if (m.layer > map.layer) learn(map, out);
  }
  if (m.layer > learned_ && m.layer > 0 && (layer_ != m.layer || !drops_.complete())) {
    waiting_ = m;
    return;
  }
  learn(m, out);
}

void DropletEstimatorNode::learn(const height_map_t& m, Outbox& out) {
  if (m.layer < learned_) return;
  const double noise = std::isfinite(m.noise_std_mm) && m.noise_std_mm > 0.0 ? m.noise_std_mm : kNoiseIfUnknown_mm;
  const LayerDrops drops = m.layer == layer_ ? drops_ : LayerDrops{};
  const auto use = drops.use_of(m, mask_);
  if (std::count(use.begin(), use.end(), droplet::Use::kNothing) == std::ptrdiff_t(use.size()))
    return warn("HEIGHT_MAP " + std::to_string(m.map_id) + " has no measured cell", out);
  try {
    if (m.layer == learned_)
      estimator_.replace_map(height_of(m), use, noise);
    else if (!estimator_.has_ground())
      estimator_.set_ground(height_of(m), use, noise);
    else
      estimator_.add_layer(drops.passes(), height_of(m), use, noise);
    learned_ = m.layer;
    publish(m, out);
  } catch (const std::invalid_argument& error) {
    warn("HEIGHT_MAP " + std::to_string(m.map_id) + ": " + error.what(), out);
  }
}

void DropletEstimatorNode::publish(const height_map_t& map, Outbox& out) {
  const droplet::Estimate& e = estimator_.estimate();
  height_model_t m{};
  m.layer = map.layer;
  m.attempt = map.attempt;
  m.map_id = map.map_id;
  m.h1_mm = e.model.h1_mm;
  m.h2_mm = e.model.h2_mm;
  m.h3_mm = e.model.h3_mm;
  std::copy(e.covariance_mm2.m.begin(), e.covariance_mm2.m.end(), m.covariance_mm2);
  m.layer_height_mm = e.model.layer_height_mm();
  m.layer_height_std_mm = e.layer_height_std_mm();
  m.excitation = e.excitation;
  m.droplet_scatter = e.droplet_scatter;
  m.fit = e.fit;
  m.layers_used = e.layers;
  m.droplets = e.droplets;
  m.evaluations = e.evaluations;
  out.send(channels::kHeightModel, m);
}

void DropletEstimatorNode::warn(const std::string& text, Outbox& out) const {
  fault_t f{};
  f.severity = std::int8_t(Severity::kWarning);
  f.node = info(NodeId::kDropletEstimator).name;
  f.text = text;
  out.send(channels::fault(NodeId::kDropletEstimator), f);
}

std::unique_ptr<Node> make_droplet_estimator(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_experiment(config_toml, "experiment.toml");
  return std::make_unique<DropletEstimatorNode>(e, mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"));
}

}  // namespace firn
