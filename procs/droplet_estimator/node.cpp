#include "procs/droplet_estimator/node.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/control/python_scheme.h"
#include "core/grid/npy.h"
#include "firn/enums.h"
#include "firn/height_model_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr double kNoiseIfUnknown_mm = 0.001;  // Lu 2015, V-B
constexpr double kShrinkage = 0.03;           // of cured ink, standard deviation of its share

droplet::EstimatorOptions options_of(const Experiment& e) {
  droplet::EstimatorOptions o = e.estimator;
  o.prior = {e.model.h1_mm, e.model.h2_mm, e.model.h3_mm};
  o.border = e.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose;
  return o;
}

}  // namespace

DropletEstimatorNode::DropletEstimatorNode(const Experiment& e, Mask mask, const Blobs& inputs)
    : grid_(e.grid), mask_(std::move(mask)), estimator_(e.grid, options_of(e)) {
  if (mask_.size() != grid_.size())
    throw std::invalid_argument("droplet_estimator: the mask does not have the grid's size");
  if (control::is_python_scheme(e.estimator.droplets))
    python_ = std::make_unique<PythonEstimator>(e, mask_, inputs);
  subscribe(channels::kDepositionReport, this);
  subscribe(channels::kHeightMap, this);
  if (e.estimator.droplets == "camera") subscribe(channels::kDropletSweep, this);
}

// Cured ink has the volume of the droplets but for its shrinkage.
void DropletEstimatorNode::on(const droplet_sweep_t& m, Time, Outbox&) {
  if (!(m.known & std::int32_t(SweepValue::kVolume)) || !(m.volume_mm3 > 0.0)) return;
  const double height_mm = m.volume_mm3 / (grid_.pitch_x_mm * grid_.pitch_y_mm),
               share = m.volume_std_mm3 / m.volume_mm3;
  estimator_.believe_height(height_mm, height_mm * std::sqrt(share * share + kShrinkage * kShrinkage));
}

void DropletEstimatorNode::on(const deposition_report_t& r, Time, Outbox& out) {
  if (from_message(r.grid) != grid_ || r.drops.size() != grid_.size())
    return out.warn("DEPOSITION_REPORT of layer " + std::to_string(r.layer) +
                    ": its grid is not the experiment's");
  if (r.layer < layer_ || r.layer <= learned_) return;  // of a layer that has been taken in without it
  if (r.layer > layer_) {
    layer_ = r.layer;
    drops_ = {};
  }
  drops_.add({drops_of(r), r.pass_index, r.passes, r.triggered_jet, r.unknown_from, r.unknown_to});
  if (!waiting_ || waiting_->layer != layer_ || !drops_.complete()) return;
  const height_map_t map = std::move(*waiting_);
  waiting_.reset();
  learn(map, out);
}

void DropletEstimatorNode::on(const height_map_t& m, Time, Outbox& out) {
  if (from_message(m.grid) != grid_ || m.height_mm.size() != grid_.size() || m.quality.size() != grid_.size())
    return out.warn("HEIGHT_MAP " + std::to_string(m.map_id) + ": its grid is not the experiment's");
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
  const double noise =
      std::isfinite(m.noise_std_mm) && m.noise_std_mm > 0.0 ? m.noise_std_mm : kNoiseIfUnknown_mm;
  const droplet::LayerDrops drops = m.layer == layer_ ? drops_ : droplet::LayerDrops{};
  const auto use = drops.use_of(height_of(m), m.quality, mask_);
  if (std::count(use.begin(), use.end(), droplet::Use::kNothing) == std::ptrdiff_t(use.size()))
    return out.warn("HEIGHT_MAP " + std::to_string(m.map_id) + " has no measured cell");
  try {
    const droplet::Estimate& estimate = estimate_with(m, drops, use, noise);
    learned_ = m.layer;
    publish(m, estimate, out);
  } catch (const std::invalid_argument& error) {
    out.warn("HEIGHT_MAP " + std::to_string(m.map_id) + ": " + error.what());
  } catch (const std::runtime_error& error) {
    out.report(Severity::kStop, error.what());
  }
}

const droplet::Estimate& DropletEstimatorNode::estimate_with(const height_map_t& m,
                                                             const droplet::LayerDrops& drops,
                                                             const std::vector<droplet::Use>& use,
                                                             double noise) {
  const HeightMap height = height_of(m);
  if (python_) return python_->learn({drops.passes(), height, use, m.layer, m.attempt, noise});
  if (m.layer == learned_)
    estimator_.replace_map(height, use, noise);
  else if (!estimator_.has_substrate())
    estimator_.set_substrate(height, use, noise);
  else
    estimator_.add_layer(drops.passes(), height, use, noise);
  return estimator_.estimate();
}

void DropletEstimatorNode::publish(const height_map_t& map, const droplet::Estimate& e, Outbox& out) {
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

std::unique_ptr<Node> make_droplet_estimator(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  return std::make_unique<DropletEstimatorNode>(e, mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"),
                                                blobs);
}

}  // namespace firn
