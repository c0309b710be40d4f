#include "procs/scheduler/layer_job.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/grid/firing_order.h"
#include "firn/enums.h"
#include "lcmtypes/convert.h"

namespace firn {
namespace {

constexpr std::size_t kMaxPasses =
    127;  // layer_plan_t counts so many droplets of a cell, a pass so many passes

// The most triggers of the stage after a stop has disarmed the jet: each of the two obeys it in its own time.
std::int64_t triggers_after(std::int64_t disarmed_us, std::int64_t last_us, double triggers_per_s) {
  constexpr double kMore = 2.0;  // one for the ends of the time, one for the ripple of the speed
  if (last_us < disarmed_us) return 0;
  return std::int64_t(1e-6 * double(last_us - disarmed_us) * triggers_per_s + kMore);
}

}  // namespace

LayerJob::LayerJob(const layer_plan_t& plan, MaterialMap materials, int sub_patterns,
                   const OffsetTable& places)
    : layer_(plan.layer),
      map_id_(plan.map_id),
      sub_patterns_(sub_patterns),
      plan_(drops_of(plan)),
      materials_(std::move(materials)),
      placement_{places, offsets_of(plan), 0.0} {
  const std::string what = "layer " + std::to_string(layer_) + ": ";
  if (!materials_.cells.empty() && materials_.spec != plan_.spec)
    throw std::invalid_argument(what + "the materials are on another grid than the plan");
  try {
    check(placement_, plan_.spec);
  } catch (const std::invalid_argument& problem) {
    throw std::invalid_argument(what + problem.what());
  }
  for (std::size_t c = 0; c < materials_.size(); ++c)
    if (plan_.cells[c] > 0 && materials_.of(c) == Material::kNone)
      throw std::invalid_argument(what + "cell " + std::to_string(c) + " is to get droplets of no ink");
  passes_ = passes_of(plan_, materials_, sub_patterns_, placement_);
  if (passes_.size() > kMaxPasses)
    throw std::invalid_argument(what + std::to_string(passes_.size()) +
                                " passes; a pass has a number of at most " + std::to_string(kMaxPasses));
  begin_pass();
}

void LayerJob::begin_pass() {
  fires_ = DropletPattern(plan_.spec);
  if (finished()) return;
  const Pass& pass = passes_[std::size_t(pass_)];
  for (int j = 0; j < plan_.spec.ny; ++j)
    for (int i = 0; i < plan_.spec.nx; ++i)
      fires_.at(i, j) = firn::fires(pass, plan_, materials_, sub_patterns_, i, j, placement_);
}

std::int64_t LayerJob::remaining() const { return std::ranges::count(fires_.cells, std::uint8_t(1)); }

deposition_report_t LayerJob::settle(const answer_t& stage, const answer_t& jet, double triggers_per_s) {
  const auto order = firing_order(fires_, 0, placement_);
  const std::int64_t n = std::int64_t(order.size());
  const Outcome outcome = Outcome(stage.outcome);

  // A prefix of the firing order is known to be fired; the following droplets are in doubt up to unknown_to.
  std::int64_t known = std::clamp<std::int64_t>(stage.counted, 0, n);
  std::int64_t doubt_to = known;
  if (outcome == Outcome::kDone) {
    known = doubt_to = n;
  } else if (outcome == Outcome::kFailed && stage.counted < 0 && stage.unknown_to <= stage.unknown_from) {
    known = 0;  // it failed and counted nothing: all is in doubt
    doubt_to = n;
  } else if (outcome == Outcome::kUnknown || outcome == Outcome::kFailed) {
    if (stage.unknown_to > stage.unknown_from) known = std::clamp<std::int64_t>(stage.unknown_from, 0, n);
    doubt_to = std::clamp<std::int64_t>(stage.unknown_to, known, n);
  }
  bool jet_in_doubt = Outcome(jet.outcome) == Outcome::kUnknown && doubt_to > 0;
  if (jet_in_doubt) {
    known = 0;  // the stage's pulses are counted, the jet may have obeyed any of them or none
  } else if (jet.until_utime_us > 0 && known > 0) {
    const std::int64_t last_us = stage.until_utime_us > 0 ? stage.until_utime_us : stage.header.utime_us;
    const std::int64_t late = triggers_after(jet.until_utime_us, last_us, triggers_per_s);
    jet_in_doubt = late > 0;
    known -= std::min(known, late);
  }

  deposition_report_t r{};
  r.layer = layer_;
  r.attempt = attempt_;
  r.pass_index = pass_;
  r.passes = passes();
  r.map_id = map_id_;
  const Pass& pass = passes_[std::size_t(pass_)];
  r.material = std::int8_t(pass.material);
  r.round = pass.round;
  r.sub_pattern = pass.sub_pattern;
  r.sub_patterns = sub_patterns_;
  r.cured = pass.cure;
  r.outcome = jet_in_doubt ? std::int8_t(Outcome::kUnknown) : stage.outcome;
  r.commanded = n;
  r.triggered_stage = stage.counted;
  r.triggered_jet = jet.counted;
  r.confirmed = -1;
  r.unknown_from = known;
  r.unknown_to = doubt_to;
  r.grid = to_message(fires_.spec);
  r.n = std::int32_t(fires_.size());
  r.drops.assign(fires_.size(), 0);
  for (const std::uint32_t cell : order) r.drops[cell] = 1;

  fired_ += known;
  for (std::int64_t k = 0; k < known; ++k) fires_.cells[order[std::size_t(k)]] = 0;
  if (doubt_to > known) {
    in_doubt_ = closed_ = true;
  } else if (known == n) {
    ++pass_;
    attempt_ = 0;
    begin_pass();
  } else {
    ++attempt_;
  }
  return r;
}

}  // namespace firn
