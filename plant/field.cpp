#include "plant/field.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {
namespace {

constexpr int kMaxBox = 32;  // fine cells along a footprint's side

// Worth wider vector instructions where there are some; no fused operations and no reordered sums, so the
// bytes are the same with either.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FIRN_PLANT_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define FIRN_PLANT_CLONES
#endif

/// Part of the field under a footprint, nx x ny fine cells.
struct Window {
  double* solid;
  double* liquid;
  int stride, nx, ny;
};

/// Working arrays of one footprint, rows of kWidth cells.
template <int kWidth>
struct Work {
  double weight[kWidth][kWidth], other[kWidth][kWidth], net[kWidth][kWidth];
};

/// Weights of the footprint: cap and film are paraboloids 1 - (r/R)^2, each normalised by its own sum; then
/// low ground is preferred: each share is weighed by 1 + (mean - z) / bias, held within 0 .. 2. Then the
/// liquid is added.
/// @param u, v the centre in fine cells from the window's corner
template <int kWidth>
inline __attribute__((always_inline)) void spread(const Window& w, Work<kWidth>& work, const DropletParams& p,
                                                  double depth_cells, double u, double v, double dx,
                                                  double dy) {
  const double ic = 1.0 / (p.cap_radius_mm * p.cap_radius_mm),
               fc = 1.0 / (p.film_radius_mm * p.film_radius_mm);
  double rx2[kWidth], cap_column[kWidth] = {}, film_column[kWidth] = {}, column[kWidth] = {};
  for (int a = 0; a < w.nx; ++a) {
    const double r = (a + 0.5 - u) * dx;
    rx2[a] = r * r;
  }
  for (int b = 0; b < w.ny; ++b) {
    const double r = (b + 0.5 - v) * dy, ry2 = r * r;
    double* cap = work.weight[b];
    double* film = work.other[b];
    for (int a = 0; a < w.nx; ++a) {
      const double r2 = rx2[a] + ry2, c = 1.0 - r2 * ic, f = 1.0 - r2 * fc;
      cap[a] = c > 0.0 ? c : 0.0;
      film[a] = f > 0.0 ? f : 0.0;
      cap_column[a] += cap[a];
      film_column[a] += film[a];
    }
  }
  double cap_sum = 0.0, film_sum = 0.0;
  for (int a = 0; a < w.nx; ++a) cap_sum += cap_column[a], film_sum += film_column[a];
  const double cap_scale = cap_sum > 0.0 ? (1.0 - p.film_share) / cap_sum : 0.0;
  const double film_scale = (cap_sum > 0.0 ? p.film_share : 1.0) / film_sum;

  for (int b = 0; b < w.ny; ++b) {
    double* weight = work.weight[b];
    double* z = work.other[b];
    const double* solid = w.solid + b * w.stride;
    const double* liquid = w.liquid + b * w.stride;
    for (int a = 0; a < w.nx; ++a) {
      weight[a] = cap_scale * weight[a] + film_scale * z[a];
      z[a] = solid[a] + liquid[a];
      column[a] += weight[a] * z[a];
    }
  }
  double mean = 0.0, sum = 0.0;
  for (int a = 0; a < w.nx; ++a) mean += column[a], column[a] = 0.0;
  const double steepness = 1.0 / p.slope_bias_mm;
  for (int b = 0; b < w.ny; ++b) {
    double* weight = work.weight[b];
    const double* z = work.other[b];
    for (int a = 0; a < w.nx; ++a) {
      double g = 1.0 + (mean - z[a]) * steepness;
      g = g > 0.0 ? g : 0.0;
      g = g < 2.0 ? g : 2.0;
      weight[a] *= g;
      column[a] += weight[a];
    }
  }
  for (int a = 0; a < w.nx; ++a) sum += column[a];
  const double depth = depth_cells / sum;
  for (int b = 0; b < w.ny; ++b)
    for (int a = 0; a < w.nx; ++a) w.liquid[b * w.stride + a] += depth * work.weight[b][a];
}

/// One levelling step: fluxes from the old heights, then all exchanges, so that the result does not depend on
/// the order of cells. run_share <= 1/4 keeps every cell's liquid >= 0.
template <int kWidth>
inline __attribute__((always_inline)) void level(const Window& w, Work<kWidth>& work, double rate,
                                                 double run_share) {
  auto& z = work.weight;
  auto& give = work.other;
  auto& net = work.net;
  for (int b = 0; b < w.ny; ++b)
    for (int a = 0; a < w.nx; ++a) {
      const double wet = w.liquid[b * w.stride + a];
      z[b][a] = w.solid[b * w.stride + a] + wet;
      give[b][a] = run_share * wet;
      net[b][a] = 0.0;
    }
  double flux[kWidth];
  const auto exchange = [&](int n, const double* za, const double* zb, const double* ga, const double* gb,
                            double* from, double* to) {
    for (int a = 0; a < n; ++a) {
      double q = rate * (za[a] - zb[a]);
      q = q < ga[a] ? q : ga[a];
      flux[a] = q > -gb[a] ? q : -gb[a];
    }
    for (int a = 0; a < n; ++a) from[a] -= flux[a];
    for (int a = 0; a < n; ++a) to[a] += flux[a];
  };
  for (int b = 0; b < w.ny; ++b) exchange(w.nx - 1, z[b], z[b] + 1, give[b], give[b] + 1, net[b], net[b] + 1);
  for (int b = 0; b + 1 < w.ny; ++b) exchange(w.nx, z[b], z[b + 1], give[b], give[b + 1], net[b], net[b + 1]);
  for (int b = 0; b < w.ny; ++b)
    for (int a = 0; a < w.nx; ++a) w.liquid[b * w.stride + a] += net[b][a];
}

template <int kWidth>
inline __attribute__((always_inline)) void land_in(const Window& w, const DropletParams& p,
                                                   double depth_cells, double u, double v, double dx,
                                                   double dy) {
  Work<kWidth> work;
  spread(w, work, p, depth_cells, u, v, dx, dy);
  for (int n = 0; n < p.levelling_steps; ++n) level(w, work, p.levelling, p.run_share);
}

FIRN_PLANT_CLONES void land_on(const Window& w, const DropletParams& p, double depth_cells, double u,
                               double v, double dx, double dy) {
  if (w.nx <= 16 && w.ny <= 16)
    land_in<16>(w, p, depth_cells, u, v, dx, dy);
  else
    land_in<kMaxBox>(w, p, depth_cells, u, v, dx, dy);
}

}  // namespace

Field::Field(const GridSpec& grid, int fine_cells, int margin_cells)
    : grid_(grid),
      fine_(fine_cells),
      margin_(margin_cells),
      width_((grid.nx + 2 * margin_cells) * fine_cells),
      height_((grid.ny + 2 * margin_cells) * fine_cells),
      dx_mm_(grid.pitch_x_mm / fine_cells),
      dy_mm_(grid.pitch_y_mm / fine_cells),
      left_mm_(grid.origin_x_mm - (0.5 + margin_cells) * grid.pitch_x_mm),
      bottom_mm_(grid.origin_y_mm - (0.5 + margin_cells) * grid.pitch_y_mm),
      solid_(std::size_t(width_) * height_, 0.0),
      liquid_(solid_.size(), 0.0) {}

bool Field::land(const DropletParams& p, double volume_mm3, double x_mm, double y_mm) {
  ledger_.landed += volume_mm3;
  const double u = (x_mm - left_mm_) / dx_mm_, v = (y_mm - bottom_mm_) / dy_mm_;  // in fine cells
  const double reach_mm = std::max(p.cap_radius_mm, p.film_radius_mm);
  const double reach_x = reach_mm / dx_mm_, reach_y = reach_mm / dy_mm_;
  const bool inside = u >= reach_x + 1 && v >= reach_y + 1 && u + reach_x + 1 <= width_ &&
                      v + reach_y + 1 <= height_;  // false for NaN as well
  if (!inside) {
    ledger_.lost += volume_mm3;
    return false;
  }
  // The window reaches one fine cell beyond the footprint, so that levelling can enlarge it.
  const int a0 = int(u - reach_x - 0.5), b0 = int(v - reach_y - 0.5);
  const int nx = std::min(int(u + reach_x + 1.5) - a0, kMaxBox),
            ny = std::min(int(v + reach_y + 1.5) - b0, kMaxBox);
  const std::size_t corner = std::size_t(b0) * width_ + a0;
  land_on({solid_.data() + corner, liquid_.data() + corner, width_, nx, ny}, p,
          volume_mm3 / (dx_mm_ * dy_mm_), u - a0, v - b0, dx_mm_, dy_mm_);
  return true;
}

void Field::cure(double shrink) {
  double liquid = 0.0;
  for (std::size_t n = 0; n < liquid_.size(); ++n) {
    liquid += liquid_[n];
    solid_[n] += liquid_[n] * (1.0 - shrink);
    liquid_[n] = 0.0;
  }
  ledger_.shrunk += liquid * shrink * dx_mm_ * dy_mm_;
}

HeightMap Field::cell_means() const {
  HeightMap means(grid_, 0.0);
  for (int j = 0; j < grid_.ny; ++j)
    for (int i = 0; i < grid_.nx; ++i) {
      double sum = 0.0;
      for (int b = 0; b < fine_; ++b)
        for (int a = 0; a < fine_; ++a)
          sum += surface_mm(std::size_t((j + margin_) * fine_ + b) * width_ + (i + margin_) * fine_ + a);
      means.at(i, j) = sum / (fine_ * fine_);
    }
  return means;
}

double Field::volume_mm3() const {
  double sum = 0.0;
  for (std::size_t n = 0; n < solid_.size(); ++n) sum += surface_mm(n);
  return sum * dx_mm_ * dy_mm_;
}

}  // namespace firn::plant
