#include "estimators/surface/path_readings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/statistics/median.h"
#include "estimators/surface/robust_smoothing.h"
#include "estimators/surface/surface_map.h"

namespace firn::surface {
namespace {

constexpr double kMinSpike_mm = 0.05;
constexpr int kHalfWindow = 3;

// Difference of each value from the median of the seven about it.
std::vector<double> off_their_neighbours(const std::vector<SurfacePoint>& points, std::size_t first) {
  const std::size_t n = points.size() - first;
  std::vector<double> off(n, 0.0), window;
  if (n < 2 * kHalfWindow + 1) return off;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = std::min(i < kHalfWindow ? 0 : i - kHalfWindow, n - (2 * kHalfWindow + 1));
    window.clear();
    for (std::size_t k = from; k <= from + 2 * kHalfWindow; ++k) window.push_back(points[first + k].z_mm);
    off[i] = std::abs(points[first + i].z_mm - statistics::upper_median(window));
  }
  return off;
}

std::int64_t drop_spikes(std::vector<SurfacePoint>& points, std::size_t first) {
  const std::vector<double> off = off_their_neighbours(points, first);
  if (off.empty()) return 0;
  std::vector<double> sorted = off;
  const double most = std::max(kMinSpike_mm, 4.0 * statistics::kMadToStd * statistics::upper_median(sorted));
  std::size_t kept = first;
  for (std::size_t i = 0; i < off.size(); ++i)
    if (off[i] <= most) points[kept++] = points[first + i];
  const auto dropped = std::int64_t(points.size() - kept);
  points.resize(kept);
  return dropped;
}

}  // namespace

ReadingCounts add_readings(const Trajectory& t, const LaserFrame& frame, double period_s,
                           std::span<const float> reading_mm, std::vector<SurfacePoint>& points) {
  const int joints = frame.arm.joints();
  if (t.axes < joints || !(t.tick_s > 0.0))
    throw std::invalid_argument("trajectory " + std::to_string(t.id) + " has " + std::to_string(t.axes) +
                                " axes, the arm " + std::to_string(joints));
  if (!(std::isfinite(period_s) && period_s > 0.0))
    throw std::invalid_argument("the period of the readings must be above 0");
  ReadingCounts counts;
  const std::size_t samples = t.samples(), first = points.size();
  if (samples < 2) return counts;
  const double end_s = t.tick_s * double(samples - 1);

  struct Valid {
    double ticks, reading_mm;
  };
  std::vector<Valid> valid;
  for (std::size_t k = 0; k < reading_mm.size(); ++k) {
    const double at_s = frame.latency_s + double(k) * period_s;
    if (at_s < 0.0 || at_s > end_s) continue;
    ++counts.taken;
    if (std::isfinite(reading_mm[k]))
      valid.push_back({at_s / t.tick_s, double(reading_mm[k])});
    else
      ++counts.invalid;
  }
  motion::Jets q(motion::kMaxJoints, valid.size()), flange(motion::kTaskAxes, valid.size()),
      focus(motion::kTaskAxes, valid.size());
  for (std::size_t n = 0; n < valid.size(); ++n) {
    const std::size_t i = std::min(std::size_t(valid[n].ticks), samples - 2);
    const double share = valid[n].ticks - double(i);
    for (int a = 0; a < joints; ++a) {
      const double p0 = t.positions[i * std::size_t(t.axes) + std::size_t(a)],
                   p1 = t.positions[(i + 1) * std::size_t(t.axes) + std::size_t(a)];
      q.of(a, 0)[n] = p0 + share * (p1 - p0);
      for (int order = 1; order < 4; ++order) q.of(a, order)[n] = 0.0;
    }
  }
  frame.arm.forward(q, flange);
  motion::flange_to_tool(frame.laser, flange, focus);
  for (std::size_t n = 0; n < valid.size(); ++n)
    points.push_back({focus.of(motion::kX, 0)[n] - frame.origin.x_mm,
                      focus.of(motion::kY, 0)[n] - frame.origin.y_mm,
                      focus.of(motion::kZ, 0)[n] - frame.origin_z_mm + valid[n].reading_mm});
  counts.spikes = drop_spikes(points, first);
  return counts;
}

double noise_of_readings(std::span<const SurfacePoint> p) {
  if (p.size() < 18) return 0.0;
  std::vector<double> bend;
  for (std::size_t n = 2; n < p.size(); n += 2)
    bend.push_back(std::abs(p[n].z_mm - 2.0 * p[n - 1].z_mm + p[n - 2].z_mm));
  return statistics::kMadToStd * statistics::upper_median(bend) / std::sqrt(6.0);
}

ScatterEstimate estimate_surface(const GridSpec& grid, const Mask& footprint,
                                 std::span<const SurfacePoint> points, const ScatterOptions& options) {
  if (footprint.spec != grid) throw std::invalid_argument("the footprint is not on the map's grid");
  ScatterEstimate e{HeightMap(grid, kNotMeasured),
                    Grid<std::uint8_t>(grid, std::uint8_t(CellQuality::kGuessed))};
  e.noise_std_mm = noise_of_readings(points);
  ScatteredSurface net(points);
  const HeightMap through = net.on(grid, options.samples);

  std::vector<std::uint8_t> near(grid.size());
  const int rx = int(options.reach_mm / grid.pitch_x_mm), ry = int(options.reach_mm / grid.pitch_y_mm);
  std::vector<std::uint8_t> hit(grid.size());
  for (const SurfacePoint& p : points) {
    const double i = std::floor((p.x_mm - grid.origin_x_mm) / grid.pitch_x_mm + 0.5),
                 j = std::floor((p.y_mm - grid.origin_y_mm) / grid.pitch_y_mm + 0.5);
    if (i >= 0.0 && j >= 0.0 && i < grid.nx && j < grid.ny) hit[grid.index(int(i), int(j))] = 1;
  }
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      if (!hit[grid.index(i, j)]) continue;
      for (int y = std::max(0, j - ry); y <= std::min(grid.ny - 1, j + ry); ++y)
        for (int x = std::max(0, i - rx); x <= std::min(grid.nx - 1, i + rx); ++x) near[grid.index(x, y)] = 1;
    }

  Grid<double> weights(grid);
  double cells = 0.0, measured = 0.0;
  for (std::size_t c = 0; c < grid.size(); ++c) {
    cells += footprint.cells[c];
    if (!near[c] || !std::isfinite(through.cells[c])) continue;
    e.height.cells[c] = through.cells[c];
    if (!footprint.cells[c]) continue;
    measured += 1.0;
    e.quality.cells[c] = std::uint8_t(CellQuality::kMeasured);
    weights.cells[c] = 1.0;
  }
  e.covered_fraction = cells > 0.0 ? measured / cells : 0.0;
  if (options.smooth && measured >= 3.0) {
    HeightMap data = e.height;
    for (std::size_t c = 0; c < grid.size(); ++c)
      if (weights.cells[c] == 0.0) data.cells[c] = kNotMeasured;
    const Smoothed s = RobustSmoother(grid).smooth(data, &weights, {});
    for (std::size_t c = 0; c < grid.size(); ++c)
      e.height.cells[c] = weights.cells[c] > 0.0 ? s.height.cells[c] : kNotMeasured;
  }
  fill_from_nearest(e.height);
  return e;
}

}  // namespace firn::surface
