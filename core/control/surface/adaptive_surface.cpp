#include "core/control/surface/adaptive_surface.h"

#include <algorithm>
#include <cmath>

#include "core/control/surface/window_mean.h"

namespace firn::control {

SurfaceOptions with_adaptive(SurfaceOptions o) {
  check_extra("smf_adaptive", kAdaptiveOptions, o.extra);
  const auto take = [&](const char* name, double& value) {
    if (const auto found = o.extra.numbers.find(name); found != o.extra.numbers.end()) value = found->second;
  };
  take("adaptive_gain", o.adaptive.gain);
  if (const auto found = o.extra.integers.find("adaptive_window_cells"); found != o.extra.integers.end())
    o.adaptive.window_cells = int(found->second);
  o.adaptive.gain_min = std::min(o.adaptive.gain_min, o.adaptive.gain);
  o.adaptive.gain_max = std::max(o.adaptive.gain_max, o.adaptive.gain);
  return o;
}
namespace {

HeightMap moved(const HeightMap& from, const GridSpec& to) {
  return from.size() ? resample(from, to, kNotMeasured) : HeightMap(to, kNotMeasured);
}

}  // namespace

HeightMap AdaptiveSurface::control_law(const SurfaceMeasurement& m, const HeightMap& e, bool again) {
  if (!again) before_ = after_;
  const bool first = before_.error.size() == 0 && m.layer > 0;
  const SurfaceAdaptiveOptions& o = options_.adaptive;
  const HeightMap last = moved(before_.error, e.spec), done = moved(before_.executed, e.spec),
                  old_d = moved(before_.disturbance, e.spec), old_gain = moved(before_.gain, e.spec),
                  old_innovation = moved(before_.innovation, e.spec);
  HeightMap innovation(e.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    innovation.cells[c] =
        last.cells[c] - done.cells[c] - old_d.cells[c] - e.cells[c];  // NaN where one of them is not known
  after_ = {e, e, e, window_mean(innovation, o.window_cells, o.window_cells), HeightMap()};
  HeightMap u(e.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c) {
    if (!std::isfinite(e.cells[c])) continue;
    double gain = std::isfinite(old_gain.cells[c]) ? old_gain.cells[c] : o.gain;
    double d = std::isfinite(old_d.cells[c]) ? old_d.cells[c] : 0.0;
    if (std::isfinite(innovation.cells[c])) {
      const double now = after_.innovation.cells[c], before = old_innovation.cells[c];
      const double largest = std::max(now * now, before * before);
      if (std::isfinite(before) && largest > 0.0)
        gain = std::clamp(gain + o.gain_rate * now * before / largest, o.gain_min, o.gain_max);
      d += gain * innovation.cells[c];
    } else if (first) {
      d = -gain * e.cells[c];  // the first interval was laid on the bare table, at u = 0
    }
    after_.gain.cells[c] = gain;
    after_.disturbance.cells[c] = d;
    u.cells[c] = o.kp * (e.cells[c] + target_offset()) - d;
  }
  return u;
}

void AdaptiveSurface::executed(const HeightMap& u) { after_.executed = u; }

}  // namespace firn::control
