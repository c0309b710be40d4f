#include "procs/flow_estimator/node.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "config/ice_lab.h"
#include "core/slice/coverage/footprint.h"
#include "firn/enums.h"
#include "firn/flow_model_t.hpp"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr double kDoubtReach_cells = 3.0;

GridSpec union_of(const slice::PrintPaths& paths, double pitch_mm) {
  if (paths.layers.empty()) throw std::invalid_argument("paths: there is no layer to print");
  double i0 = 0.0, j0 = 0.0, i1 = 0.0, j1 = 0.0;
  bool first = true;
  for (const slice::LayerPaths& layer : paths.layers) {
    const GridSpec g = slice::footprint_grid(layer, pitch_mm);
    const double i = std::floor(g.origin_x_mm / pitch_mm + 0.5),
                 j = std::floor(g.origin_y_mm / pitch_mm + 0.5);
    i0 = first ? i : std::min(i0, i);
    j0 = first ? j : std::min(j0, j);
    i1 = first ? i + g.nx : std::max(i1, i + g.nx);
    j1 = first ? j + g.ny : std::max(j1, j + g.ny);
    first = false;
  }
  return {int(i1 - i0), int(j1 - j0), pitch_mm, pitch_mm, i0 * pitch_mm, j0 * pitch_mm};
}

motion::Tool tool_of(const slice::PrintPaths& paths, const Machine& machine, std::size_t material) {
  const std::string name =
      material < paths.head.materials.size() ? paths.head.materials[material].tool : "scaffold";
  for (const motion::Tool& t : tools(machine))
    if (t.name == name) return t;
  throw std::invalid_argument("paths: tool \"" + name + "\" is not one of the machine's");
}

}  // namespace

FlowEstimatorNode::FlowEstimatorNode(const Experiment& e, const Machine& machine,
                                     const slice::PrintPaths& paths)
    : grid_(union_of(paths, e.ice.pitch_mm)),
      arm_(make_arm(machine)),
      tools_{tool_of(paths, machine, 0), tool_of(paths, machine, 1)},
      latency_s_{e.valve_a.latency_s, e.valve_b.latency_s},
      origin_{e.ice.origin_x_mm, e.ice.origin_y_mm},
      min_measured_fraction_(e.process.min_measured_fraction),
      estimator_(flow::FlowOptions{}),
      laid_(nothing()),
      laid_before_(nothing()),
      newest_(grid_, 0.0),
      before_(grid_, 0.0) {
  subscribe(channels::kTrajectory, this);
  subscribe(channels::kPulseList, this);
  subscribe(channels::kPathReport, this);
  subscribe(channels::kHeightMap, this);
}

void FlowEstimatorNode::on(const trajectory_t& m, Time, Outbox&) {
  if (m.kind == std::int8_t(PathKind::kMeasurement)) return;
  motions_[m.path] = from_message(m).trajectory;
  if (const auto report = early_.find(m.path); report != early_.end()) add(report->second);
}

void FlowEstimatorNode::on(const pulse_list_t& m, Time, Outbox&) {
  lists_[m.path].push_back(m);
  if (const auto report = early_.find(m.path); report != early_.end()) add(report->second);
}

void FlowEstimatorNode::on(const path_report_t& m, Time, Outbox&) {
  if (m.kind != std::int8_t(PathKind::kMeasurement)) add(m);
}

void FlowEstimatorNode::add(const path_report_t& m) {
  const auto motion = motions_.find(m.path);
  const auto lists = lists_.find(m.path);
  if (motion == motions_.end() || lists == lists_.end() ||
      std::int32_t(lists->second.size()) < lists->second.front().lists) {
    early_[m.path] = m;  // trajectories and lists have other channels
    return;
  }
  const std::size_t valve = m.material == 0 ? 0 : 1;
  const bool nothing_ran =
      m.outcome == std::int8_t(Outcome::kNone) || m.outcome == std::int8_t(Outcome::kRefused);
  HeightMap path(grid_, 0.0);
  for (const pulse_list_t& l : lists->second)
    if (!nothing_ran)
      flow::add_laid({motion->second, l.start_s, l.tick_s, latency_s_[valve], l.volume_mm3, l.tick},
                     {*arm_, tools_[valve], origin_}, path);
  const double fired = m.pulses_counted >= 0 && m.pulses_commanded > 0
                           ? double(m.pulses_counted) / double(m.pulses_commanded)
                           : 1.0;
  const bool doubt = m.outcome != std::int8_t(Outcome::kDone);
  const int reach = int(kDoubtReach_cells);
  for (int j = 0; j < grid_.ny; ++j)
    for (int i = 0; i < grid_.nx; ++i) {
      if (path.at(i, j) == 0.0) continue;
      if (!doubt) {
        laid_[valve].at(i, j) += fired * path.at(i, j);
        continue;
      }
      for (int y = std::max(0, j - reach); y <= std::min(grid_.ny - 1, j + reach); ++y)
        for (int x = std::max(0, i - reach); x <= std::min(grid_.nx - 1, i + reach); ++x)
          laid_[valve].at(x, y) = kNotMeasured;
    }
  motions_.erase(m.path);
  lists_.erase(m.path);
  early_.erase(m.path);
}

void FlowEstimatorNode::on(const height_map_t& m, Time, Outbox& out) {
  if (!(m.measured_fraction >= min_measured_fraction_) || m.layer < layer_) return;
  if (m.height_mm.size() != m.quality.size())
    return out.warn("HEIGHT_MAP " + std::to_string(m.map_id) + " has no quality of each cell");
  HeightMap known = height_of(m);
  for (std::size_t c = 0; c < known.size(); ++c)
    if (m.quality[c] != std::int8_t(CellQuality::kMeasured)) known.cells[c] = kNotMeasured;
  if (m.layer > layer_) {
    before_ = newest_;
    laid_before_ = laid_;
    laid_ = nothing();
    layer_ = m.layer;
  }
  newest_ = resample(known, grid_, kNotMeasured);
  if (m.layer == 0) return;  // the bare table: the base of the first interval
  flow::FlowInterval interval{m.layer, HeightMap(grid_), laid_before_};
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    interval.rise_mm.cells[c] = newest_.cells[c] - before_.cells[c];
    for (HeightMap& n : interval.nominal_mm) {
      if (std::isfinite(n.cells[c])) continue;
      interval.rise_mm.cells[c] = kNotMeasured;
      n.cells[c] = 0.0;
    }
  }
  estimator_.add(interval);
  const flow::FlowEstimate& e = estimator_.estimate();
  flow_model_t f{};
  f.layer = m.layer;
  f.attempt = m.attempt;
  f.map_id = m.map_id;
  for (std::size_t v = 0; v < 2; ++v) {
    f.factor[v] = e.factor[v];
    f.factor_std[v] = e.factor_std[v];
    f.drift_per_layer[v] = e.drift_per_layer[v];
  }
  f.fit = e.fit;
  f.maps_used = e.intervals;
  f.evaluations = e.evaluations;
  out.send(channels::kFlowModel, std::move(f));
}

std::unique_ptr<Node> make_flow_estimator(const std::string& config_toml, const Blobs& blobs) {
  const Experiment e = parse_recorded_experiment(config_toml, "experiment.toml");
  const std::vector<std::byte>& machine = blob(blobs, "machine").bytes;
  return std::make_unique<FlowEstimatorNode>(
      e, parse_machine(std::string(reinterpret_cast<const char*>(machine.data()), machine.size()), "machine"),
      slice::decode_print_paths(blob(blobs, "paths").bytes));
}

}  // namespace firn
