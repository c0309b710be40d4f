#include "core/control/target_offset.h"

namespace firn::control {

Decision TargetOffset::decide(const Measurement& m) {
  if (offset_mm_ == 0.0) return inner().decide(m);
  HeightMap height = m.height;
  for (double& h : height.cells) h -= offset_mm_;  // NaN stays NaN
  HeightMap estimate;
  if (m.estimate) estimate = *m.estimate;
  for (double& h : estimate.cells) h -= offset_mm_;
  return inner().decide(
      {height, m.layer, m.attempt, m.noise_std_mm, m.estimate ? &estimate : nullptr, m.estimate_std_mm});
}

}  // namespace firn::control
