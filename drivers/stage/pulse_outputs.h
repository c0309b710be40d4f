// PulseOutputs computes the requests that arm the pulse outputs of the controller, less the settings that it
// holds already.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/link/link.h"
#include "drivers/stage/ensemble.h"
#include "drivers/stage/stage_config.h"

namespace firn::drivers {

class PulseOutputs {
 public:
  /// Nothing is known of the controller, which holds `increments` of them.
  void forget(int increments);
  void resize(int increments) { held_.resize(std::size_t(increments), -1); }
  /// A way sets up the output of X in its own mode and overwrites the increments.
  void lend_to_way();
  /// The controller has taken increment `index`.
  void acknowledged(std::size_t index) { held_[index] = -2 - held_[index]; }

  /// Queues the requests for pulses at `increments` [counts] from the arming position on, then arms the axis.
  void arm_row(int axis, std::span<const std::int64_t> increments, const StageConfig& config,
               const ensemble::Table& table, Link& link);
  /// The same for pulses every `pitch_mm`.
  void arm_scan(int axis, double pitch_mm, const StageConfig& config, const ensemble::Table& table,
                Link& link);

 private:
  void set_up(int axis, const StageConfig& config, const ensemble::Table& table, Link& link);

  std::vector<std::int64_t> held_;  // IGLOBALs from first_iglobal; -1 = not known, below = sent
  std::array<bool, 3> set_up_{};
};

}  // namespace firn::drivers
