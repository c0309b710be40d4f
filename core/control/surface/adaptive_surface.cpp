#include "core/control/surface/adaptive_surface.h"

#include <algorithm>
#include <cmath>

namespace firn::control {
namespace {

// Mean over the finite cells of a square about each finite cell: running sums along rows, then along columns.
HeightMap averaged(const HeightMap& v, int half) {
  const GridSpec& g = v.spec;
  HeightMap sum(g, 0.0), count(g, 0.0), out(g, kNotMeasured);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      for (int x = std::max(0, i - half); x <= std::min(g.nx - 1, i + half); ++x)
        if (std::isfinite(v.at(x, j))) sum.at(i, j) += v.at(x, j), count.at(i, j) += 1.0;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (!std::isfinite(v.at(i, j))) continue;
      double total = 0.0, n = 0.0;
      for (int y = std::max(0, j - half); y <= std::min(g.ny - 1, j + half); ++y) total += sum.at(i, y), n += count.at(i, y);
      out.at(i, j) = total / n;
    }
  return out;
}

HeightMap moved(const HeightMap& from, const GridSpec& to) {
  return from.size() ? resample(from, to, kNotMeasured) : HeightMap(to, kNotMeasured);
}

}  // namespace

HeightMap AdaptiveSurface::control_law(const SurfaceMeasurement& m, const HeightMap& e, bool again) {
  if (!again) before_ = after_;
  const bool first = before_.error.size() == 0 && m.layer > 0;
  const SurfaceAdaptiveOptions& o = options_.adaptive;
  const HeightMap last = moved(before_.error, e.spec), done = moved(before_.executed, e.spec), old_d = moved(before_.disturbance, e.spec),
                  old_gain = moved(before_.gain, e.spec), old_innovation = moved(before_.innovation, e.spec);
  HeightMap innovation(e.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c)
    innovation.cells[c] = last.cells[c] - done.cells[c] - old_d.cells[c] - e.cells[c];  // NaN where one of them is not known
  after_ = {e, e, e, averaged(innovation, o.window_cells), HeightMap()};
  HeightMap u(e.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c) {
    if (!std::isfinite(e.cells[c])) continue;
    double gain = std::isfinite(old_gain.cells[c]) ? old_gain.cells[c] : o.gain;
    double d = std::isfinite(old_d.cells[c]) ? old_d.cells[c] : 0.0;
    if (std::isfinite(innovation.cells[c])) {
      const double now = after_.innovation.cells[c], before = old_innovation.cells[c];
      const double largest = std::max(now * now, before * before);
      if (std::isfinite(before) && largest > 0.0) gain = std::clamp(gain + o.gain_rate * now * before / largest, o.gain_min, o.gain_max);
      d += gain * innovation.cells[c];
    } else if (first) {
      d = -gain * e.cells[c];  // the first interval was laid on the bare table, at u = 0
    }
    after_.gain.cells[c] = gain;
    after_.disturbance.cells[c] = d;
    u.cells[c] = o.kp * e.cells[c] - d;
  }
  return u;
}

void AdaptiveSurface::executed(const HeightMap& u) { after_.executed = u; }

}  // namespace firn::control
