// FocusControl holds the lines' width by the sheath's gas: surface-mapping feedback [Barnett 2012, 5.1] on
// the squared width, once a layer.
#pragma once

#include <cstdint>

#include "core/control/lines/line_options.h"
#include "core/control/options.h"

namespace firn::control {

/// Layers of equal section add up their squared widths, so with q = mean over the lines of (width / nominal
/// width)^2 after k layers the next layer shall have 1 + U of the nominal squared width, U = Kp e + Ki* sum e
/// within +-output_limit, e = k (1 - q). A stronger sheath focuses: to first order 1 / width^2 = (1 + (share
/// - 1) / slope) / effect, where the effect, 1 at first, is learned from the last layer's own k q - (k - 1)
/// q_before.
class FocusControl {
 public:
  FocusControl(const LineOptions& options, const SmfGains& gains, double output_limit);

  /// Returns the sheath's gas of layer k + 1 in shares of the nominal one, within 1 -+ sheath_range. A second
  /// measurement of a layer starts from the state before it.
  /// @param squared_width q after `layer` layers; NaN: not known, the share stays
  double next_share(std::int32_t layer, double squared_width);
  void use_options(const LineOptions& options, const SmfGains& gains);

 private:
  LineOptions options_;
  SmfGains gains_;
  double output_limit_;
  struct Memory {
    std::int32_t layer = 0;
    double squared_width = 0.0;  ///< after `layer` layers; NaN: not known
    double sum = 0.0, effect = 1.0;
    double share = 1.0;  ///< of the layer after `layer`
  };
  Memory before_, now_;
};

}  // namespace firn::control
