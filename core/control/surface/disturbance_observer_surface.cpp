#include "core/control/surface/disturbance_observer_surface.h"

#include <cmath>
#include <limits>

#include "core/control/surface/window_mean.h"

namespace firn::control {
namespace {

constexpr double kSlopeKept = 0.8, kSlopeShare = 0.4;  // phi, beta: a drift goes on, and dies away
constexpr double kFirstShare = 0.3;   // of the first map, where the table's shape is not known
constexpr double kStartShare = 1.2;   // beta of the first map where it is: a drift has begun at nothing, and
                                      // its mean so far is a third of the next
constexpr double kBorderLack = 0.05;  // intervals that cells at a border lack in the first one, and half of
                                      // it behind them: beads round off there

struct Nearest {
  double mm2 = std::numeric_limits<double>::infinity();
  bool bare = false;
};

std::size_t material_of(std::uint8_t cell) { return cell == std::uint8_t(CellMaterial::kScaffold) ? 1 : 0; }

/// Mean of v over the finite cells of each class; 0 where a class has none. Classes of -1 do not count.
template <std::size_t N, class Class>
std::array<double, N> class_means(const HeightMap& v, const Class& class_of) {
  std::array<double, N> sum{}, cells{};
  for (std::size_t c = 0; c < v.size(); ++c)
    if (std::isfinite(v.cells[c])) {
      sum[std::size_t(class_of(c))] += v.cells[c];
      cells[std::size_t(class_of(c))] += 1.0;
    }
  for (std::size_t n = 0; n < N; ++n) sum[n] = cells[n] > 0.0 ? sum[n] / cells[n] : 0.0;
  return sum;
}

std::array<double, kZones> lack_at_borders() {
  std::array<double, kZones> d{};
  for (std::size_t z = 0; z < d.size(); ++z)
    d[z] = z % kZoneBands < 2 ? -kBorderLack : z % kZoneBands == 2 ? -0.5 * kBorderLack : 0.0;
  return d;
}

}  // namespace

Grid<std::int8_t> zones(const Grid<std::uint8_t>& material, double band_mm) {
  const GridSpec& g = material.spec;
  const double far_mm = band_mm * (kZoneBands - 1);
  const int rx = int(std::ceil(far_mm / g.pitch_x_mm)), ry = int(std::ceil(far_mm / g.pitch_y_mm));
  Grid<std::int8_t> out(g, std::int8_t(-1));
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::uint8_t own = material.at(i, j);
      if (!own) continue;
      Nearest nearest;
      for (int y = j - ry; y <= j + ry; ++y)
        for (int x = i - rx; x <= i + rx; ++x) {
          const std::uint8_t other = g.contains(x, y) ? material.at(x, y) : std::uint8_t(0);
          if (other == own) continue;
          const double dx = (x - i) * g.pitch_x_mm, dy = (y - j) * g.pitch_y_mm, mm2 = dx * dx + dy * dy;
          if (mm2 < nearest.mm2 || (mm2 == nearest.mm2 && other == 0)) nearest = {mm2, other == 0};
        }
      const bool far = !(nearest.mm2 < far_mm * far_mm);
      const int band = far ? kZoneBands - 1 : int(std::sqrt(nearest.mm2) / band_mm);
      out.at(i, j) =
          std::int8_t((int(material_of(own)) * 2 + (nearest.bare && !far ? 1 : 0)) * kZoneBands + band);
    }
  return out;
}

HeightMap square_mean(const HeightMap& values, double side_mm) {
  const GridSpec& g = values.spec;
  return window_mean(values, int(0.5 * side_mm / g.pitch_x_mm + 1e-9),
                     int(0.5 * side_mm / g.pitch_y_mm + 1e-9));
}

HeightMap DisturbanceObserverSurface::control_law(const SurfaceMeasurement& m, const HeightMap& e,
                                                  bool again) {
  if (!again) before_ = after_;
  const SurfaceForeseeOptions& o = options_.foresee;
  const bool first = before_.error.size() == 0;
  const bool of_table = before_.of_table;
  const auto moved = [&](const HeightMap& from) {
    return first ? HeightMap(e.spec, 0.0) : resample(from, e.spec, kNotMeasured);
  };
  const HeightMap last = moved(before_.error), done = moved(before_.executed);
  const Grid<std::int8_t> zone = zones(m.material, o.zone_mm);
  const auto material = [&](std::size_t c) { return material_of(m.material.cells[c]); };

  after_ = before_;
  if (m.layer == 0) after_.zone = lack_at_borders();
  after_.wide = carried_over(before_.wide, e.spec);
  std::array<double, 2> foreseen{};
  for (std::size_t n = 0; n < 2; ++n) foreseen[n] = after_.material[n] += kSlopeKept * after_.slope[n];
  HeightMap v(e.spec, kNotMeasured);  // innovation
  for (std::size_t c = 0; c < e.size(); ++c)
    if (std::isfinite(e.cells[c]) && m.layer == 0)
      v.cells[c] = 0.0;  // the map of the bare table has no information on the deposition
    else if (std::isfinite(e.cells[c]))
      v.cells[c] = last.cells[c] - done.cells[c] - e.cells[c] - foreseen[material(c)] -
                   after_.zone[std::size_t(zone.cells[c])] - after_.wide.cells[c];
  const auto of_material = class_means<2>(v, material);
  for (std::size_t c = 0; c < v.size(); ++c)
    if (std::isfinite(v.cells[c])) v.cells[c] -= of_material[material(c)];
  const auto of_zone = class_means<kZones>(v, [&](std::size_t c) { return zone.cells[c]; });
  for (std::size_t c = 0; c < v.size(); ++c)
    if (std::isfinite(v.cells[c])) v.cells[c] -= of_zone[std::size_t(zone.cells[c])];
  const HeightMap wide = square_mean(v, o.wide_mm);

  for (std::size_t n = 0; n < of_material.size(); ++n) {
    // The first map contains the table's own shape, which is corrected but does not last.
    const double learned = (first ? kFirstShare : 1.0) * o.flow_gain * of_material[n];
    after_.slope[n] =
        kSlopeKept * after_.slope[n] + (first ? 0.0 : (of_table ? kStartShare : kSlopeShare) * learned);
    after_.material[n] += learned;
  }
  for (std::size_t n = 0; n < of_zone.size(); ++n) after_.zone[n] += o.zone_gain * of_zone[n];
  const HeightMap about = square_mean(e, o.narrow_mm);
  after_.error = e;
  after_.of_table = m.layer == 0;
  after_.disturbance = HeightMap(e.spec, kNotMeasured);
  HeightMap u(e.spec, kNotMeasured);
  for (std::size_t c = 0; c < e.size(); ++c) {
    if (!std::isfinite(e.cells[c])) continue;
    if (!first && std::isfinite(wide.cells[c])) after_.wide.cells[c] += o.wide_gain * wide.cells[c];
    const double d = after_.material[material(c)] + kSlopeKept * after_.slope[material(c)] +
                     after_.zone[std::size_t(zone.cells[c])] + after_.wide.cells[c];
    after_.disturbance.cells[c] = d;
    u.cells[c] =
        o.kp * (about.cells[c] + target_offset() + o.narrow_gain * (e.cells[c] - about.cells[c])) - d;
  }
  return u;
}

}  // namespace firn::control
