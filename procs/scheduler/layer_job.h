// LayerJob holds the state of one layer: the commanded passes, the droplets known to be fired, the droplets
// in doubt.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "core/grid/material.h"
#include "core/grid/offsets.h"
#include "firn/answer_t.hpp"
#include "firn/deposition_report_t.hpp"
#include "firn/layer_plan_t.hpp"
#include "procs/scheduler/pass_list.h"

namespace firn {

class LayerJob {
 public:
  LayerJob() = default;
  /// @param materials without cells: one ink. @param sub_patterns 1, 2 or 4
  /// @param places of the plan's offsets
  /// @throws std::invalid_argument: more than 127 passes; a cell with droplets and no ink, a map of another
  /// size, or an offset beyond the table.
  explicit LayerJob(const layer_plan_t& plan, MaterialMap materials = {}, int sub_patterns = 1,
                    const OffsetTable& places = {});

  int layer() const { return layer_; }
  std::int64_t map_id() const { return map_id_; }
  int pass() const { return pass_; }
  int passes() const { return int(passes_.size()); }
  int attempt() const { return attempt_; }
  bool finished() const { return closed_ || pass_ >= passes(); }
  const DropletPattern& plan() const { return plan_; }
  const MaterialMap& materials() const { return materials_; }
  bool in_doubt() const { return in_doubt_; }
  std::int64_t fired() const { return fired_; }

  /// Returns the ink of the current pass. @pre not finished
  Material material() const { return passes_[std::size_t(pass_)].material; }
  /// Returns whether the current pass has small droplets. @pre not finished
  bool small() const { return passes_[std::size_t(pass_)].small; }
  /// Returns true if wet droplets must be cured before the next pass: always, except between the inks and
  /// sizes of one sub-pattern.
  bool cure_due() const {
    return finished() || attempt_ > 0 || pass_ == 0 || passes_[std::size_t(pass_) - 1].cure;
  }

  /// Returns the pattern of the current pass: 1 for cells to fire. Cells that this pass has already fired are
  /// 0, so that a later attempt does not repeat them.
  const DropletPattern& fires() const { return fires_; }
  std::int64_t remaining() const;  ///< droplets that the current pass still has to fire
  const OffsetMap& offsets() const { return placement_.map; }
  /// The places of these droplets and the order in which they come. keep_apart() sets the distance of those
  /// of one run before the pass is commanded (drivers/stage/raster.h).
  const Placement& placement() const { return placement_; }
  void keep_apart(double apart_mm) { placement_.apart_mm = apart_mm; }

  /// Records the stage's answer to the current pass. Fired droplets are never fired again. Everything fired:
  /// the next pass is current. A known prefix: the rest remains for the next attempt. Doubt: the layer is
  /// closed, and only a scan shows the result.
  /// @param jet the answer to its disarming: kUnknown puts every pulse of the pass in doubt, a stop that
  /// disarmed it the pulses that may have come later; its count cannot reduce a doubt and is only reported
  /// @param triggers_per_s the most that the stage makes, of node time
  deposition_report_t settle(const answer_t& stage, const answer_t& jet, double triggers_per_s);

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
  Placement placement_;
  std::vector<Pass> passes_;
  DropletPattern fires_;  ///< 0 or 1: droplets that the current pass still has to fire
};

}  // namespace firn
