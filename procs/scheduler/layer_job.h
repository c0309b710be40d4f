// Bookkeeping of one layer: what each pass commanded, what is known to have been fired, what is in doubt.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "procs/scheduler/pass_list.h"

namespace firn {

class LayerJob {
 public:
  LayerJob() = default;
  /// @param materials without cells: one ink. @param sub_patterns 1, 2 or 4
  /// @throws std::invalid_argument: more than 127 passes; a cell with droplets and no ink, or a map of
  /// another size.
  explicit LayerJob(const layer_plan_t& plan, MaterialMap materials = {}, int sub_patterns = 1);

  int layer() const { return layer_; }
  std::int64_t map_id() const { return map_id_; }
  int pass() const { return pass_; }
  int passes() const { return int(passes_.size()); }
  int attempt() const { return attempt_; }
  bool finished() const { return closed_ || pass_ >= passes(); }
  bool in_doubt() const { return in_doubt_; }
  std::int64_t fired() const { return fired_; }

  /// Of the current pass. @pre not finished
  Material material() const { return passes_[std::size_t(pass_)].material; }
  /// Whether what lies wet is cured before anything else is fired: always, but between the inks of one
  /// sub-pattern.
  bool cure_due() const {
    return finished() || attempt_ > 0 || pass_ == 0 || passes_[std::size_t(pass_) - 1].cure;
  }

  /// 1 where the current pass fires: without the cells that it has already fired, so that they are not fired
  /// again.
  const DropletPattern& fires() const { return fires_; }
  std::int64_t remaining() const;  ///< droplets that the current pass still has to fire

  /// The stage's answer to the current pass. What was fired is never fired again. Everything fired: the next
  /// pass is current. A known prefix: the rest stays to do, as the next attempt. Doubt: the layer is closed,
  /// and only a scan tells. The jet's own count may narrow nothing, so it is only reported.
  deposition_report_t settle(const answer_t& stage, std::int64_t jet_counted);

 private:
  void begin_pass();

  int layer_ = 0;
  std::int64_t map_id_ = 0;
  int pass_ = 0;
  int attempt_ = 0;
  int sub_patterns_ = 1;
  bool closed_ = false;
  bool in_doubt_ = false;
  std::int64_t fired_ = 0;
  DropletPattern plan_;
  MaterialMap materials_;
  std::vector<Pass> passes_;
  DropletPattern fires_;  ///< 0 or 1: what the current pass still has to fire
};

}  // namespace firn
