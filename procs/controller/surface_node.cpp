#include "procs/controller/surface_node.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "config/ice_lab.h"
#include "core/control/python_scheme.h"
#include "core/slice/coverage/footprint.h"
#include "firn/control_surface_t.hpp"
#include "firn/enums.h"
#include "lcmtypes/convert.h"
#include "procs/controller/python_surface.h"

namespace firn {

SurfaceControllerNode::SurfaceControllerNode(const Experiment& e, slice::PrintPaths paths,
                                             const Blobs& inputs)
    : changes_(e),
      paths_(e.ice.map_table == "on" ? slice::with_table(std::move(paths)) : std::move(paths)),
      pitch_mm_(e.ice.pitch_mm),
      min_measured_fraction_(e.process.min_measured_fraction) {
  if (paths_.layers.empty()) throw std::invalid_argument("paths: there is no layer to print");
  const control::SurfaceOptions options = surface_options(e, paths_.layers.back().layer);
  version_ = options.version;
  own_source_ = own_source(e.flow.feed_forward);
  feed_forward_ = options.feed_forward && own_source_.empty();
  scheme_ = control::is_python_scheme(options.scheme) ? make_python_surface(options, e.plant.seed, inputs)
                                                      : control::make_surface_controller(options);
  subscribe(channels::kHeightMap, this);
  subscribe(channels::kOperatorCommand, this);
  if (feed_forward_) subscribe(channels::kFlowModel, this);
  if (!own_source_.empty()) subscribe(channels::kOwnFlowModel, this);
}

control::SurfaceDecision SurfaceControllerNode::decide(const height_map_t& m) {
  const slice::LayerPaths* layer = slice::find_layer(paths_, m.layer);
  if (!layer)
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": the print has no layer " +
                                std::to_string(m.layer));
  const GridSpec grid = slice::footprint_grid(*layer, pitch_mm_);
  if (from_message(m.grid) != grid || m.height_mm.size() != grid.size())
    throw std::invalid_argument("HEIGHT_MAP " + std::to_string(m.map_id) + ": its grid of " +
                                std::to_string(m.grid.nx) + " x " + std::to_string(m.grid.ny) +
                                " cells is not layer " + std::to_string(m.layer) + "'s of " +
                                std::to_string(grid.nx) + " x " + std::to_string(grid.ny));
  const double noise = std::isfinite(m.noise_std_mm) && m.noise_std_mm > 0.0 ? m.noise_std_mm : 0.0;
  return scheme_->decide({height_of(m), slice::footprint_materials(*layer, grid),
                          layer->z * geometry::kMmPerUnit, m.layer, m.attempt, noise});
}

void SurfaceControllerNode::start(const Start& start, Time, Outbox&) {
  if (start.resumed()) scheme_->looked_after();
}

void SurfaceControllerNode::on(const height_map_t& m, Time, Outbox& out) {
  if (!(m.measured_fraction >= min_measured_fraction_)) return;
  // The bare table holds no information on the valves.
  if (feed_forward_ && m.layer > 0 && m.map_id != told_)
    waiting_ = m;
  else
    answer(m, out);
}

void SurfaceControllerNode::answer(const height_map_t& m, Outbox& out) {
  control_surface_t answer{};
  answer.layer = m.layer;
  answer.attempt = m.attempt;
  answer.map_id = m.map_id;
  answer.version =
      std::int8_t(version_ == control::SurfaceVersion::kPathSpeed ? ControlVersion::kPathSpeed
                                                                  : ControlVersion::kValveFrequency);
  answer.grid = m.grid;
  control::SurfaceDecision d;
  try {
    d = decide(m);
  } catch (const std::exception& error) {
    d.reason = error.what();
    d.u = HeightMap(from_message(m.grid), 0.0);
    out.report(Severity::kStop, error.what());
  }
  answer.decision = std::int8_t(d.kind);
  answer.saturated_fraction = d.saturated_fraction;
  answer.rms_mm = d.rms_mm;
  answer.mean_error_mm = d.mean_error_mm;
  answer.feed_forward[0] = d.feed_forward[0];
  answer.feed_forward[1] = d.feed_forward[1];
  answer.reason = d.reason;
  answer.n = std::int32_t(d.u.size());
  for (const double u : d.u.cells) answer.u.push_back(float(u));
  out.send(channels::kControlSurface, std::move(answer));
}

void SurfaceControllerNode::on(const operator_command_t& m, Time, Outbox&) {
  if (OperatorVerb(m.verb) != OperatorVerb::kSet || !changes_.take(m.command_id)) return;
  if (changes_.set(m.key, m.value).empty())
    scheme_->use_options(surface_options(changes_.experiment(), paths_.layers.back().layer));
}

void SurfaceControllerNode::on(const own_flow_model_t& m, Time, Outbox&) {
  if (m.program == own_source_) scheme_->use_flow({m.factor[0], m.factor[1]});
}

void SurfaceControllerNode::on(const flow_model_t& m, Time, Outbox& out) {
  if (m.maps_used > 0) scheme_->use_flow({m.factor[0], m.factor[1]});
  told_ = m.map_id;
  if (waiting_ && waiting_->map_id == m.map_id) answer(std::exchange(waiting_, std::nullopt).value(), out);
}

}  // namespace firn
