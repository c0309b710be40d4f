// Bookkeeping of one layer: what each pass commanded, what is known to have been fired, what is in doubt.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/layer_plan_t.hpp"

namespace firn {

class LayerJob {
 public:
  LayerJob() = default;
  explicit LayerJob(const layer_plan_t& plan);

  int layer() const { return layer_; }
  std::int64_t map_id() const { return map_id_; }
  int pass() const { return pass_; }
  int passes() const { return passes_; }
  int attempt() const { return attempt_; }
  bool finished() const { return closed_ || pass_ >= passes_; }
  bool in_doubt() const { return in_doubt_; }
  std::int64_t fired() const { return fired_; }

  /// Droplet counts to send for the current pass: cells that this pass has already fired are lowered, so that they
  /// are not fired again.
  const DropletPattern& drops() const { return drops_; }
  std::int64_t remaining() const;  ///< droplets that the current pass still has to fire

  /// The stage's answer to the current pass. What was fired is never fired again. Everything fired: the next pass
  /// is current. A known prefix: the rest stays to do, as the next attempt. Doubt: the layer is closed, and only a
  /// scan tells. The jet's own count may narrow nothing, so it is only reported.
  deposition_report_t settle(const answer_t& stage, std::int64_t jet_counted);

 private:
  int layer_ = 0;
  std::int64_t map_id_ = 0;
  int pass_ = 0;
  int passes_ = 0;
  int attempt_ = 0;
  bool closed_ = false;
  bool in_doubt_ = false;
  std::int64_t fired_ = 0;
  DropletPattern plan_;
  DropletPattern drops_;  ///< plan_, lowered to pass_ where this pass has fired
};

}  // namespace firn
