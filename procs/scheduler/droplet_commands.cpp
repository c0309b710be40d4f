// Commands that the droplet loop sends on entering a phase, and reports of the loop.
#include <algorithm>
#include <cmath>

#include "firn/jet_command_t.hpp"
#include "firn/lamp_command_t.hpp"
#include "firn/stage_command_t.hpp"
#include "lcmtypes/convert.h"
#include "procs/scheduler/droplet_loop.h"

namespace firn {
namespace {

double extent_mm(int n, double pitch_mm) { return (n + 1) * pitch_mm; }

}  // namespace

void DropletLoop::proceed(Phase next, Time now, Outbox& out) {
  count_phase_time(now);
  if (next == Phase::kArmJet && job_.finished()) {
    if (layers_done_ != job_.layer()) {
      layers_done_ = job_.layer();
      scan_attempt_ = 0;
    }
    next = Phase::kArmProfiler;
  }
  phase_ = next;
  const bool nothing_wet = next == Phase::kArmProfiler || (next == Phase::kArmJet && job_.cure_due());
  if (nothing_wet && holds(place(), out)) return;
  if (enter_watch(next, now, out) || enter_scan(next, now, out)) return;
  switch (next) {
    case Phase::kArmJet:
      return send_jet(JetVerb::kArm, now, out);
    case Phase::kPass:
      return send_pass(now, out);
    case Phase::kDisarmJet:
      return send_jet(JetVerb::kDisarm, now, out);
    case Phase::kPark:
      return send_park(now, out);
    case Phase::kCure:
      return send_exposure(now, out);
    default:
      return;
  }
}

void DropletLoop::send_pass(Time now, Outbox& out) {
  const DropletPattern& fires = job_.fires();
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kPass);
  c.attempt = job_.attempt();
  c.pass = job_.pass();
  c.speed_mm_s = experiment().process.pass_speed_mm_s;
  c.z_mm = experiment().process.nozzle_gap_mm;
  c.grid = to_message(fires.spec);
  c.lead_mm = job_.material() == Material::kA ? lead_mm_ : 0.0;
  if (job_.material() == Material::kB) {  // nozzle B is above the cell
    c.grid.origin_x_mm -= experiment().jet_b.offset_x_mm;
    c.grid.origin_y_mm -= experiment().jet_b.offset_y_mm;
    c.z_mm += experiment().jet_b.offset_z_mm;
  }
  c.n = std::int32_t(fires.size());
  c.fires.assign(fires.cells.begin(), fires.cells.end());
  const double row_s = extent_mm(fires.spec.nx, fires.spec.pitch_x_mm) / c.speed_mm_s + 1.0;
  stamp(c, NodeId::kStage, fires.spec.ny * row_s, now, out);
  out.send(channels::kStageCommand, c);
}

void DropletLoop::send_park(Time now, Outbox& out) {
  stage_command_t c{};
  c.verb = std::int8_t(StageVerb::kMove);
  c.x_mm = experiment().process.park_x_mm;
  c.y_mm = experiment().process.park_y_mm;
  c.z_mm = experiment().process.nozzle_gap_mm;
  c.speed_mm_s = experiment().process.pass_speed_mm_s;
  stamp(c, NodeId::kStage, 10.0, now, out);
  out.send(channels::kStageCommand, c);
}

void DropletLoop::send_jet(JetVerb verb, Time now, Outbox& out) {
  jet_command_t c{};
  c.verb = std::int8_t(verb);
  c.attempt = job_.attempt();
  c.pass = job_.pass();
  c.expected = job_.remaining();
  const bool b = job_.material() == Material::kB;
  stamp(c, b ? NodeId::kJetB : NodeId::kJet, 10.0, now, out);
  out.send(b ? channels::kJetBCommand : channels::kJetCommand, c);
}

void DropletLoop::send_exposure(Time now, Outbox& out) {
  lamp_command_t c{};
  c.verb = std::int8_t(LampVerb::kExpose);
  c.attempt = job_.attempt();
  c.exposure_s = experiment().process.exposure_s;
  c.iris_percent = experiment().process.iris_percent;
  stamp(c, NodeId::kLamp, c.exposure_s + 10.0, now, out);
  out.send(channels::kLampCommand, c);
}

void DropletLoop::publish_metrics(const height_map_t& map, Time now, Outbox& out) {
  layer_metrics_t m = metrics_of(map, now);
  if (map.rows_expected > 0) {
    const HeightMap height = measured_height_of(map);
    m.rms_inside_mm = error_stats(height, target(), inside_).rms_mm;
    m.rms_rim_mm = error_stats(height, target(), rim_).rms_mm;
  }
  m.drops = map.layer > 0 ? job_.fired() : 0;
  m.drops_total = drops_total_;
  m.objective_mm = objective_mm_;
  m.iterations = iterations_;
  // The mean height added per layer gives the number of layers to the target; before the first layer the
  // nominal layer height.
  const ModelConfig& h = experiment().model;
  const double per_layer = map.layer > 0 && m.mean_height_mm > 0 ? m.mean_height_mm / map.layer
                                                                 : h.h1_mm + 4 * h.h2_mm + 4 * h.h3_mm;
  m.layers_expected = std::int32_t(std::min(1e6, std::ceil(m.target_mean_mm / per_layer)));
  out.send(channels::kLayerMetrics, m);
}

}  // namespace firn
