#include "procs/controller/node.h"

#include <cmath>
#include <exception>
#include <utility>

#include "config/labs.h"
#include "core/control/auto/auto_scheme.h"
#include "core/control/python_scheme.h"
#include "core/grid/npy.h"
#include "core/path/job_codec.h"
#include "firn/enums.h"
#include "firn/layer_plan_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/controller/line_node.h"
#include "procs/controller/python_controller.h"
#include "procs/controller/surface_node.h"

namespace firn {
namespace {

constexpr TimerId kLateReports{1};
constexpr double kWaitForReports_s = 2.0;

// Returns whether the height estimate knows this lab: one ink, raw maps, droplets in the middles of cells.
bool can_estimate(const Experiment& e) {
  return !has_two_jets(e) && e.control.smoothing == 0.0 && OffsetTable(e.actuation).size() == 1;
}

// The experiment whose height estimate goes to scheme auto.
Experiment with_estimate_of_auto(Experiment e) {
  e.control.height_estimate = "kalman";
  e.control.droplet_factors = "together";
  e.control.filter.droplet_scatter = control::kAutoScatter;
  return e;
}

}  // namespace

control::ControlOptions control_options(const Experiment& e) {
  control::ControlOptions o = e.control;
  if (o.mpc.error != control::ErrorKind::kAbsolute) {
    const deposition::DropletModel h{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm};
    const double scatter = e.control.filter.droplet_scatter;
    o.mpc.price_mm2 = scatter * scatter * h.sum_of_squares_mm2();
  }
  if (e.control.droplet_factors == "together") o.mpc.rim_lead_layers = control::kRimLead_layers;
  return o;
}

control::Setup control_setup(const Experiment& e, HeightMap target, Mask mask,
                             std::shared_ptr<const Geometry> geometry) {
  const OffsetTable places(e.actuation);
  const deposition::DropletModel a{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm},
      b{e.model.g1_mm, e.model.g2_mm, e.model.g3_mm};
  return {e.grid,
          std::move(target),
          std::move(mask),
          a,
          e.model.border == "keep" ? deposition::Border::kKeep : deposition::Border::kLose,
          e.control.seed,
          std::move(geometry),
          b,
          e.geometry.judge_above_layers * a.layer_height_mm(),
          {},
          offset_model(a, places, e.actuation.heights_mm, e.actuation.flow_range_mm),
          offset_model(b, places, {}, e.actuation.flow_range_mm)};
}

std::unique_ptr<control::LayerController> make_scheme(const control::Setup& setup,
                                                      const control::ControlOptions& options,
                                                      const Blobs& inputs) {
  return control::is_python_scheme(options.scheme) ? make_python_controller(setup, options, inputs)
                                                   : control::make_controller(setup, options);
}

ControllerNode::ControllerNode(const Experiment& e, HeightMap target, Mask mask,
                               std::shared_ptr<const Geometry> geometry, const Blobs& inputs)
    : changes_(e),
      own_source_(own_source(e.control.adapt_model)),
      grid_(e.grid),
      beside_map_(e.control.scheme == "auto"),
      known_(control_setup(e, target, mask, geometry)),
      wait_s_(kWaitForReports_s * e.run.time_scale) {
  if (beside_map_ && can_estimate(e))
    estimate_.emplace(with_estimate_of_auto(e), mask);
  else if (!beside_map_ && e.control.height_estimate == "kalman")
    estimate_.emplace(e, mask);
  control::Setup setup = control_setup(e, std::move(target), std::move(mask), std::move(geometry));
  model_ = setup.model;
  if (estimate_ && estimate_->factors()) {
    setup.model_b = setup.model;
    setup.rim = Mask(e.grid);
    for (std::size_t c = 0; c < setup.rim.size(); ++c)
      setup.rim.cells[c] = estimate_->factors()->places().cells[c] == droplet::Place::kRim;
  }
  scheme_ = make_scheme(setup, control_options(e), inputs);
  subscribe(channels::kHeightMap, this);
  subscribe(channels::kOperatorCommand, this);
  if (e.control.adapt_model == "on") subscribe(channels::kHeightModel, this);
  if (!own_source_.empty()) subscribe(channels::kOwnHeightModel, this);
  if (estimate_) subscribe(channels::kDepositionReport, this);
}

void ControllerNode::on(const height_map_t& m, Time now, Outbox& out) {
  if (waiting_) {  // the newer map holds more information
    waiting_.reset();
    out.cancel(kLateReports);
  }
  if (!estimate_ || estimate_->ready(m)) return answer(m, out);
  waiting_ = m;
  out.wake_at(kLateReports, now.after_s(wait_s_));
}

// The scheduler reports a change that cannot be made.
void ControllerNode::on(const operator_command_t& m, Time, Outbox&) {
  if (OperatorVerb(m.verb) != OperatorVerb::kSet || !changes_.take(m.command_id)) return;
  if (changes_.set(m.key, m.value).empty()) scheme_->use_options(control_options(changes_.experiment()));
}

void ControllerNode::on(const deposition_report_t& r, Time, Outbox& out) {
  estimate_->take(r);
  if (!waiting_ || !estimate_->ready(*waiting_)) return;
  out.cancel(kLateReports);
  const height_map_t map = std::move(*waiting_);
  waiting_.reset();
  answer(map, out);
}

void ControllerNode::wake(TimerId timer, Time, Outbox& out) {
  if (timer != kLateReports || !waiting_) return;
  const height_map_t map = std::move(*waiting_);
  waiting_.reset();
  out.warn("what was fired for layer " + std::to_string(map.layer) +
           " has not been reported; its map counts alone");
  answer(map, out);
}

control::Decision ControllerNode::decide(const height_map_t& m) {
  if (from_message(m.grid) != grid_ || m.height_mm.size() != grid_.size())
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": grid " +
                                std::to_string(m.grid.nx) + " x " + std::to_string(m.grid.ny) + " with " +
                                std::to_string(m.height_mm.size()) + " heights is not the experiment's " +
                                std::to_string(grid_.nx) + " x " + std::to_string(grid_.ny));
  if (estimate_) {
    estimate_->take(m);
    if (const auto* factors = estimate_->factors())
      scheme_->use_models(model_.times(factors->at(droplet::Place::kInside)),
                          model_.times(factors->at(droplet::Place::kRim)));
    if (beside_map_) return decide_on_map(m);
    return scheme_->decide({estimate_->height(), m.layer, m.attempt, estimate_->std_mm()});
  }
  return decide_on_map(m);
}

control::Decision ControllerNode::decide_on_map(const height_map_t& m) {
  const double noise = std::isfinite(m.noise_std_mm) && m.noise_std_mm > 0.0 ? m.noise_std_mm : 0.0;
  const bool counted = m.rows_expected > 0;
  HeightMap height = counted ? known_.filled(height_of(m), m.quality, m.layer) : height_of(m);
  control::Measurement measured{height, m.layer, m.attempt, noise};
  HeightMap estimate;
  if (estimate_) {
    estimate = estimate_->height();
    measured.estimate = &estimate;
    measured.estimate_std_mm = estimate_->std_mm();
  }
  control::Decision d = scheme_->decide(measured);
  if (counted) known_.keep(std::move(height), m.layer, d.drops, d.materials, d.offsets);
  return d;
}

void ControllerNode::answer(const height_map_t& m, Outbox& out) {
  layer_plan_t plan{};
  plan.layer = m.layer + 1;
  plan.attempt = m.attempt;
  plan.map_id = m.map_id;
  control::Decision d;
  d.drops = DropletPattern(grid_);
  try {
    d = decide(m);
  } catch (const std::exception& error) {
    d.kind = control::Decision::Kind::kStop;
    d.reason = error.what();
    out.report(Severity::kStop, error.what());
  }
  if (!d.notice.empty()) out.report(Severity::kNotice, d.notice);
  plan.decision = std::int8_t(d.kind);
  plan.objective_mm = d.objective_mm;
  plan.objective_none_mm = d.objective_none_mm;
  plan.iterations = d.iterations;
  plan.reason = d.reason;
  set_drops(plan, d.drops);
  if (d.kind == control::Decision::Kind::kPrint) {
    set_materials(plan, d.materials);
    set_offsets(plan, d.offsets);
  }
  out.send(channels::kLayerPlan, std::move(plan));
}

void ControllerNode::on(const height_model_t& m, Time, Outbox&) {
  if (m.layers_used <= 0) return;
  scheme_->use_model({m.h1_mm, m.h2_mm, m.h3_mm});
  if (estimate_) estimate_->use_model({m.h1_mm, m.h2_mm, m.h3_mm}, m.droplet_scatter);
}

void ControllerNode::on(const own_height_model_t& m, Time, Outbox&) {
  if (m.program != own_source_) return;
  scheme_->use_model({m.h1_mm, m.h2_mm, m.h3_mm});
  if (estimate_) estimate_->use_model({m.h1_mm, m.h2_mm, m.h3_mm}, m.droplet_scatter);
}

std::unique_ptr<Node> make_controller_node(const std::string& config_toml, const Blobs& blobs) {
  return make_controller_node_on(serially, config_toml, blobs);
}

std::unique_ptr<Node> make_controller_node_on(const ParallelFor& parallel, const std::string& config_toml,
                                              const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  if (prints_paths(e))
    return std::make_unique<SurfaceControllerNode>(e, slice::decode_print_paths(blob(blobs, "paths").bytes),
                                                   blobs);
  if (prints_lines(e)) {
    const std::vector<std::byte>& machine = blob(blobs, "machine").bytes;
    const std::string text(reinterpret_cast<const char*>(machine.data()), machine.size());
    return std::make_unique<LineControllerNode>(
        e, parse_machine(text, "machine"), decode_job(blob(blobs, "job").bytes),
        height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"));
  }
  std::shared_ptr<const Geometry> geometry;
  if (e.geometry.solid.kind != "none")
    geometry = std::make_shared<const Geometry>(
        geometry_from_bytes(blob(blobs, "geometry").bytes, e.grid, "geometry"));
  auto node = std::make_unique<ControllerNode>(
      e, height_map_from_npy(blob(blobs, "target").bytes, e.grid, "target"),
      mask_from_npy(blob(blobs, "mask").bytes, e.grid, "mask"), std::move(geometry), blobs);
  node->use_threads(parallel);
  return node;
}

}  // namespace firn
