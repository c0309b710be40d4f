#include "core/control/surface/smf_surface.h"

#include <algorithm>
#include <cmath>

namespace firn::control {

HeightMap OpenLoopSurface::control_law(const SurfaceMeasurement& m, const HeightMap&, bool) {
  return on_footprint(HeightMap(m.height.spec, 0.0), m.material);
}

HeightMap SmfSurface::control_law(const SurfaceMeasurement&, const HeightMap& e, bool again) {
  if (!again) before_ = after_;
  const SmfGains& o = options_.smf;
  const HeightMap sum = carried_over(before_.sum, e.spec);
  const HeightMap last =
      before_.error.size() ? resample(before_.error, e.spec, kNotMeasured) : HeightMap(e.spec, kNotMeasured);
  const double limit = o.ki_star > 0.0 ? o.integral_limit / o.ki_star : 0.0;
  HeightMap u(e.spec, kNotMeasured);
  after_ = {u, e};
  for (std::size_t c = 0; c < e.size(); ++c) {
    const double error = e.cells[c] + target_offset();
    if (!std::isfinite(error)) continue;
    const double total = std::clamp(sum.cells[c] + error, -limit, limit);
    after_.sum.cells[c] = total;
    u.cells[c] = o.kp * error + o.ki_star * total;
    if (std::isfinite(last.cells[c])) u.cells[c] += o.kd_star * (e.cells[c] - last.cells[c]);
  }
  return u;
}

}  // namespace firn::control
