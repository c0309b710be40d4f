// LineGrowth computes from pictures how much ink the layers added to the lines.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/control/lines/visible_width.h"

namespace firn::control {

/// A station in a layer's picture; NaN: no line seen.
struct SeenLine {
  double contrast = 0.0;
  double width_mm = 0.0, width_std_mm = 0.0;  ///< at half contrast
};

/// The growth of seen ink, relative to that of the planned ink.
struct GrowthShare {
  double share = std::numeric_limits<double>::quiet_NaN();
  double std = std::numeric_limits<double>::infinity();
  bool resolved() const { return std <= 0.1; }
};

/// The seen ink of a station is contrast x width: of thin ink the contrast grows with each layer, of thick
/// ink the width, more slowly the thicker it is. A look is compared with the last one whose growth was
/// resolved, so that growth below the noise of one layer's pictures adds up over several layers.
class LineGrowth {
 public:
  explicit LineGrowth(const VisibleWidth& visible) : visible_(visible) {}

  /// @param section_mm2 that the layer shall add, by station
  void plan(std::int32_t layer, std::vector<double> section_mm2);

  /// A second look at a layer replaces the first one. Not resolved: no earlier look, or growth below the
  /// noise.
  /// @param layer 1-based @param seen by station
  GrowthShare look(std::int32_t layer, std::span<const SeenLine> seen);

 private:
  struct Look {
    std::vector<SeenLine> seen;
    std::vector<double> planned_mm2;  ///< of all layers
  };
  GrowthShare growth() const;

  VisibleWidth visible_;
  std::int32_t planned_layer_ = 0, newest_layer_ = 0;
  std::vector<double> planned_mm2_;  ///< of planned_layer_ alone
  Look reference_, newest_;
  bool resolved_ = false;  ///< the newest one
};

}  // namespace firn::control
