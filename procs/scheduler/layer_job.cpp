#include "procs/scheduler/layer_job.h"

#include <algorithm>

#include "core/grid/firing_order.h"
#include "lcmtypes/convert.h"
#include "lcmtypes/outcome.h"

namespace firn {

LayerJob::LayerJob(const layer_plan_t& plan)
    : layer_(plan.layer), map_id_(plan.map_id), passes_(plan.passes), plan_(drops_of(plan)), drops_(plan_) {}

std::int64_t LayerJob::remaining() const { return std::int64_t(firing_order(drops_, pass_).size()); }

deposition_report_t LayerJob::settle(const answer_t& stage, std::int64_t jet_counted) {
  const auto order = firing_order(drops_, pass_);
  const std::int64_t n = std::int64_t(order.size());
  const Outcome outcome = Outcome(stage.outcome);

  // A prefix of the firing order is known to be fired; what follows is in doubt up to unknown_to.
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

  deposition_report_t r;
  r.layer = layer_;
  r.attempt = attempt_;
  r.pass = pass_;
  r.passes = passes_;
  r.map_id = map_id_;
  r.outcome = stage.outcome;
  r.commanded = n;
  r.triggered_stage = stage.counted;
  r.triggered_jet = jet_counted;
  r.confirmed = -1;
  r.unknown_from = known;
  r.unknown_to = doubt_to;
  r.grid = to_message(drops_.spec);
  r.n = std::int32_t(drops_.size());
  r.drops.assign(drops_.size(), 0);
  for (const std::uint32_t cell : order) r.drops[cell] = 1;

  fired_ += known;
  for (std::int64_t k = 0; k < known; ++k) drops_.cells[order[std::size_t(k)]] = std::uint8_t(pass_);
  if (doubt_to > known) {
    in_doubt_ = closed_ = true;
  } else if (known == n) {
    ++pass_;
    attempt_ = 0;
    drops_ = plan_;
  } else {
    ++attempt_;
  }
  return r;
}

}  // namespace firn
