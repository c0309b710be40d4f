#include "estimators/surface/surface_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/grid/avx2.h"
#include "core/statistics/median.h"

namespace firn::surface {
namespace {

constexpr double kQuartilesToStd =
    0.7413;  // standard deviation over interquartile range of a normal distribution

double median_of_sorted(const std::vector<float>& v) {
  const std::size_t half = v.size() / 2;
  return v.size() % 2 == 1 ? double(v[half]) : 0.5 * (double(v[half - 1]) + double(v[half]));
}

constexpr std::size_t kFew = 64;

/// Adds to the rank of each sample the samples below it. @param whole z.size() up to a multiple of 8
FIRN_CLONES void add_ranks(const float* z, std::size_t size, std::size_t whole, int* rank) {
  for (std::size_t j = 0; j < size; ++j) {
    const float below = z[j];
    for (std::size_t i = 0; i < whole; ++i) rank[i] += int(below < z[i]);
  }
}

/// Sorts finite samples: a cell has a few dozen, whose ranks are counted faster than they are sorted.
void sort_samples(std::vector<float>& z) {
  const std::size_t size = z.size(), whole = (size + 7) / 8 * 8;
  if (size > kFew) {
    std::sort(z.begin(), z.end());
    return;
  }
  float from[kFew] = {}, to[kFew];
  int rank[kFew] = {};
  std::copy(z.begin(), z.end(), from);
  add_ranks(from, size, whole, rank);
  std::fill_n(to, size, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < size; ++i) to[rank[i]] = from[i];
  for (std::size_t k = 0; k < size; ++k)
    z[k] = std::isnan(to[k]) ? z[k - 1] : to[k];  // equal ones share a rank
}

double mean_within(const std::vector<float>& z, double low, double high) {
  double sum = 0.0, n = 0.0;
  for (const float s : z)
    if (s >= low && s <= high) {
      sum += double(s);
      n += 1.0;
    }
  return sum / n;
}

double height_of_cell(std::vector<float>& z, CellStatistic statistic) {
  sort_samples(z);  // sums below do not depend on the order of arrival
  if (statistic == CellStatistic::kMean) return mean_within(z, z.front(), z.back());
  const double middle = median_of_sorted(z);
  if (statistic == CellStatistic::kMedian) return middle;
  const double quartiles = double(z[(3 * z.size()) / 4]) - double(z[z.size() / 4]);
  const double reach = std::max(4.0 * kQuartilesToStd * quartiles, 1e-3);
  return mean_within(z, middle - reach, middle + reach);
}

template <class Visit>
void neighbours(const GridSpec& g, int i, int j, const Visit& visit) {
  for (int y = std::max(j - 1, 0); y <= std::min(j + 1, g.ny - 1); ++y)
    for (int x = std::max(i - 1, 0); x <= std::min(i + 1, g.nx - 1); ++x)
      if (x != i || y != j) visit(g.index(x, y));
}

void replace_spikes(SurfaceEstimate& e, double spike_mm) {
  const GridSpec& g = e.height.spec;
  const HeightMap before = e.height;
  std::vector<double> around;
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (!std::isfinite(before.cells[c])) continue;
      around.clear();
      neighbours(g, i, j, [&](std::size_t n) {
        if (std::isfinite(before.cells[n])) around.push_back(before.cells[n]);
      });
      if (around.size() < 3) continue;
      const auto [low, high] = std::minmax_element(around.begin(), around.end());
      // The edge of a part has a neighbour at its own height, a slope has one higher and one lower.
      if (before.cells[c] <= *high + spike_mm && before.cells[c] >= *low - spike_mm) continue;
      e.height.cells[c] = statistics::median(around);
      e.quality.cells[c] = std::uint8_t(CellQuality::kOutlierReplaced);
      ++e.spikes;
    }
}

void fill_unmeasured(SurfaceEstimate& e) {
  const GridSpec& g = e.height.spec;
  std::vector<std::size_t> open, still_open;
  for (std::size_t c = 0; c < g.size(); ++c)
    if (!std::isfinite(e.height.cells[c])) {
      open.push_back(c);
      e.quality.cells[c] = std::uint8_t(CellQuality::kGuessed);
    }
  if (open.size() == g.size()) {
    std::fill(e.height.cells.begin(), e.height.cells.end(), 0.0);
    return;
  }
  std::vector<double> found;
  while (!open.empty()) {
    still_open.clear();
    found.clear();
    for (const std::size_t c : open) {
      double sum = 0.0, n = 0.0;
      neighbours(g, int(c) % g.nx, int(c) / g.nx, [&](std::size_t k) {
        if (std::isfinite(e.height.cells[k])) {
          sum += e.height.cells[k];
          n += 1.0;
        }
      });
      found.push_back(n > 0.0 ? sum / n : kNotMeasured);
    }
    for (std::size_t k = 0; k < open.size(); ++k) {
      if (std::isfinite(found[k]))
        e.height.cells[open[k]] = found[k];
      else
        still_open.push_back(open[k]);
    }
    open.swap(still_open);
  }
}

// Nearest cell along one axis, or -1 outside.
int cell_along(double x_mm, double origin_mm, double pitch_mm, int n) {
  const double k = std::floor((x_mm - origin_mm) / pitch_mm + 0.5);
  return k >= 0.0 && k < double(n) ? int(k) : -1;
}

}  // namespace

SurfaceMap::SurfaceMap(const GridSpec& grid) : grid_(grid), samples_(grid.size()) { check(grid); }

const std::vector<int>& SurfaceMap::columns(double x0_mm, double dx_mm, std::size_t count) {
  if (x0_mm == x0_mm_ && dx_mm == dx_mm_ && count == columns_.size()) return columns_;
  x0_mm_ = x0_mm;
  dx_mm_ = dx_mm;
  columns_.resize(count);
  for (std::size_t n = 0; n < count; ++n)
    columns_[n] = cell_along(x0_mm + double(n) * dx_mm, grid_.origin_x_mm, grid_.pitch_x_mm, grid_.nx);
  return columns_;
}

void SurfaceMap::add_row(double y_mm, double x0_mm, double dx_mm, std::span<const float> z_mm) {
  const int j = cell_along(y_mm, grid_.origin_y_mm, grid_.pitch_y_mm, grid_.ny);
  if (j < 0) return;
  if (z_mm.size() == 1) pair_with_point_before(x0_mm, z_mm[0]);
  const std::vector<int>& column = columns(x0_mm, dx_mm, z_mm.size());
  for (std::size_t n = 0; n < z_mm.size(); ++n) {
    if (!std::isfinite(z_mm[n])) continue;
    if (n % 4 == 1 && std::isfinite(z_mm[n - 1])) differences_.push_back(std::abs(z_mm[n] - z_mm[n - 1]));
    if (column[n] >= 0) samples_[grid_.index(column[n], j)].push_back(z_mm[n]);
  }
}

// A row of one point has no neighbour in it: the next row of its column is one.
void SurfaceMap::pair_with_point_before(double x_mm, float z_mm) {
  if (x_mm == point_x_mm_ && std::isfinite(point_z_mm_) && std::isfinite(z_mm)) {
    differences_.push_back(std::abs(z_mm - point_z_mm_));
    point_z_mm_ = kNoPoint;  // no sample is in two pairs
    return;
  }
  point_x_mm_ = x_mm;
  point_z_mm_ = z_mm;
}

double SurfaceMap::noise_of_one_sample() const {
  if (differences_.size() < 16) return 0.0;
  std::vector<float> d = differences_;
  return statistics::kMadToStd * statistics::median(d) / std::sqrt(2.0);
}

SurfaceEstimate SurfaceMap::estimate(const MapOptions& options) const {
  SurfaceEstimate e{HeightMap(grid_, kNotMeasured), Grid<std::uint8_t>(grid_)};
  std::vector<float> z;
  std::vector<std::size_t> counts;
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    if (samples_[c].empty()) continue;
    z = samples_[c];
    counts.push_back(z.size());
    e.height.cells[c] = height_of_cell(z, options.statistic);
  }
  e.measured_fraction = double(counts.size()) / double(grid_.size());
  if (!counts.empty()) e.noise_std_mm = noise_of_one_sample() / std::sqrt(statistics::median(counts));
  replace_spikes(e, options.spike_mm);
  fill_unmeasured(e);
  return e;
}

void SurfaceMap::clear() {
  for (auto& s : samples_) s.clear();
  differences_.clear();
  point_z_mm_ = kNoPoint;
}

}  // namespace firn::surface
