#include "core/control/mpc/reference_governor.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/control/prediction.h"
#include "core/control/stall_bound.h"

namespace firn::control {

ReferenceGovernor::ReferenceGovernor(const Setup& setup, const ControlOptions& options)
    : setup_(setup), options_(options), layer_mm_(setup.model.layer_height_mm()) {
  const double lead = options.mpc.rim_lead_layers;
  if (!(std::isfinite(lead) && lead >= 0.0))
    throw std::invalid_argument("mpc: rim_lead_layers = " + std::to_string(lead) + " must not be below 0");
  Mpc(setup, options);  // checks the options of MPC
  if (options.mpc.rise_layers > 0.0)
    rise_.emplace(setup, options.mpc.edge_lag_layers, options.mpc.rise_layers);
  rim_ = setup.rim;
  for (std::size_t c = 0; c < rim_.size(); ++c) rim_.cells[c] = rim_.cells[c] && setup.mask.cells[c];
}

void ReferenceGovernor::use_models(const deposition::DropletModel& inside,
                                   const deposition::DropletModel& rim) {
  setup_.model = inside;
  setup_.model_b = rim;
}

void ReferenceGovernor::use_options(const ControlOptions& options) {
  Mpc(setup_, options);  // checks them
  take_changeable(kMpcOptions, options.mpc, options_.mpc);
  options_.noise_gate = options.noise_gate;
  options_.stall_layers = options.stall_layers;
  if (std::exchange(options_.target_offset_mm, options.target_offset_mm) != options.target_offset_mm)
    for (StallDetector& stage : stalls_) stage.clear();
}

HeightMap ReferenceGovernor::first_stage_target() const {
  HeightMap h = setup_.target;
  const double inside_mm = options_.mpc.finish_layers * layer_mm_;
  const bool has_rim = setup_.rim.size() != 0;
  const double rim_mm =
      has_rim ? inside_mm * setup_.model_b.layer_height_mm() / setup_.model.layer_height_mm() : 0.0;
  for (std::size_t c = 0; c < h.size(); ++c)
    h.cells[c] = std::max(0.0, h.cells[c] - (has_rim && setup_.rim.cells[c] ? rim_mm : inside_mm));
  return h;
}

double ReferenceGovernor::waits_at_mm(const HeightMap& height, const HeightMap& held) const {
  double cells[2] = {}, missing_mm[2] = {};
  for (std::size_t c = 0; c < setup_.rim.size(); ++c)
    if (setup_.mask.cells[c]) {
      const std::size_t rim = setup_.rim.cells[c] != 0;
      cells[rim] += 1.0;
      missing_mm[rim] += held.cells[c] - height.cells[c];
    }
  if (!together() || cells[0] == 0.0 || cells[1] == 0.0) return 0.0;
  const double inside_mm = missing_mm[0] / cells[0], behind_mm = missing_mm[1] / cells[1] - inside_mm;
  return behind_mm > options_.mpc.rim_lead_layers * layer_mm_ ? std::max(0.0, inside_mm) : 0.0;
}

HeightMap ReferenceGovernor::governed_target(const HeightMap& height) const {
  HeightMap held = first_stage_target();
  if (const double inside_mm = waits_at_mm(height, held); inside_mm > 0.0)
    for (double& h : held.cells) h = std::max(0.0, h - inside_mm);
  return held;
}

// With L > 0: a layer of few droplets takes as long as a full one.
bool ReferenceGovernor::worth_its_time(const Decision& d) const {
  const double noise_mm = kProcessNoiseStd * layer_mm_,
               better_mm2 = d.objective_none_mm * d.objective_none_mm - d.objective_mm * d.objective_mm;
  return !together() || d.kind != Decision::Kind::kPrint || better_mm2 > kStopThreshold * noise_mm * noise_mm;
}

// With L > 0 and all but the rim finished: only droplets at the rim remain.
bool ReferenceGovernor::only_rim(const HeightMap& height) const {
  if (!together() || setup_.rim.size() == 0) return false;
  double cells = 0.0, missing_mm = 0.0;
  for (std::size_t c = 0; c < height.size(); ++c)
    if (setup_.mask.cells[c] && !setup_.rim.cells[c]) {
      cells += 1.0;
      missing_mm += setup_.target.cells[c] - height.cells[c];
    }
  return missing_mm < 0.5 * cells * setup_.model.layer_height_mm();
}

std::optional<Decision> ReferenceGovernor::decide_stage(Stage stage, HeightMap target, const Measurement& m) {
  if (stalls_[stage].stalled(options_.stall_layers)) return std::nullopt;
  Setup setup = setup_;
  setup.target = std::move(target);
  Decision d = together() ? best_of_horizons(setup, m, options_.mpc.horizon) : plan(setup, options_, m);
  if (d.kind == Decision::Kind::kEnd || !worth_its_time(d)) return std::nullopt;
  stalls_[stage].add(m, first_stage_target(), stage == kWaiting ? rim_ : setup_.mask);
  if (stalls_[stage].stalled(options_.stall_layers)) return std::nullopt;
  return d;
}

std::optional<Decision> ReferenceGovernor::rise(const Measurement& m) {
  StallDetector& stall = stalls_[kRising];
  if (!rise_ || stall.stalled(options_.stall_layers)) return std::nullopt;
  std::optional<HeightMap> target = rise_->next(first_stage_target(), m.height);
  if (!target) return std::nullopt;
  Setup setup = setup_;
  setup.target = *std::move(target);
  ControlOptions options = options_;
  options.mpc.horizon = 1;
  Decision d = plan(setup, options, m);
  if (d.kind == Decision::Kind::kEnd) return std::nullopt;
  stall.add(m, first_stage_target(), setup_.mask);
  if (stall.stalled(options_.stall_layers)) return std::nullopt;
  return d;
}

Decision ReferenceGovernor::decide(const Measurement& m) {
  check(m, setup_);
  for (StallDetector& stage : stalls_) stage.rewind(m.layer);
  if (auto d = rise(m)) {
    d->reason += ", for a target that rises with the part";
    return *std::move(d);
  }
  const double ahead_mm = waits_at_mm(m.height, first_stage_target());
  if (ahead_mm > 0.0)
    if (auto d = decide_stage(kWaiting, governed_target(m.height), m)) {
      d->reason += "; the inside waits for the rim, " + std::to_string(ahead_mm * 1e3) +
                   " um below the target of the first stage";
      return *std::move(d);
    }
  if (options_.mpc.finish_layers > 0.0 || (together() && ahead_mm == 0.0))
    if (auto d = decide_stage(kLower, first_stage_target(), m)) {
      d->reason += ", for a target so many layers lower";
      return *std::move(d);
    }
  Setup setup = setup_;
  if (only_rim(m.height)) setup.model_b = setup.model.times(kLoneShare);
  Decision d = best_of_horizons(
      setup, m, together() ? std::min(kLastHorizon, options_.mpc.horizon) : options_.mpc.horizon);
  stalls_[kLast].add(m, setup_.target, setup_.mask);
  if (d.kind == Decision::Kind::kPrint && stalls_[kLast].stalled(options_.stall_layers))
    end_print(d, stall_reason(options_.stall_layers));
  return d;
}

Decision ReferenceGovernor::plan(const Setup& setup, const ControlOptions& options,
                                 const Measurement& m) const {
  Mpc mpc(setup, options);
  mpc.use_threads(parallel_);
  return mpc.decide(m);
}

Decision ReferenceGovernor::best_of_horizons(const Setup& setup, const Measurement& m, int most) const {
  const double noise_mm = kProcessNoiseStd * setup_.model.layer_height_mm();
  std::optional<Decision> best;
  double least = 0.0;
  for (int n = 1; n <= most; ++n) {
    ControlOptions o = options_;
    o.mpc.horizon = n;
    Decision found = plan(setup, o, m);
    const bool prints = found.kind == Decision::Kind::kPrint;
    const double cost = found.objective_mm * found.objective_mm + n * noise_mm * noise_mm;
    if (best && !(prints && (best->kind != Decision::Kind::kPrint || cost < least))) continue;
    best = std::move(found);
    least = cost;
  }
  return *std::move(best);
}

}  // namespace firn::control
