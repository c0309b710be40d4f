// ControllerParameters holds the parameters that the controller of the stage reports, which must agree with
// the configuration before anything moves: a wrong number of counts per mm moves an axis to a wrong place at
// a wrong speed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "drivers/link/link.h"
#include "drivers/stage/ensemble.h"
#include "drivers/stage/raster.h"
#include "drivers/stage/stage_config.h"

namespace firn::drivers {

class ControllerParameters {
 public:
  /// Queues the questions for all of them.
  static void ask(const ensemble::Table& table, Link& link);
  /// @param argument of the question
  /// @param value NaN = none was read
  void take(std::int32_t argument, double value);

  /// The first contradiction, or nothing.
  std::optional<std::string> mismatch(const StageConfig& config,
                                      const std::array<AxisLimits, 3>& limits) const;
  int global_integers() const { return global_integers_; }

 private:
  struct Axis {
    double counts_per_unit = 0.0, low_limit_mm = 0.0, high_limit_mm = 0.0, limit_setup = 0.0;
  };
  std::array<Axis, 3> axes_{};
  int global_integers_ = 0;
};

}  // namespace firn::drivers
