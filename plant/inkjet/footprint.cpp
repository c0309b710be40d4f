#include "plant/inkjet/footprint.h"

namespace firn::plant {
namespace {

#define FIRN_INLINE [[gnu::always_inline]] inline

/// Working arrays of one footprint, rows of kWidth cells.
template <int kWidth>
struct Work {
  double weight[kWidth][kWidth], other[kWidth][kWidth], net[kWidth][kWidth];
};

/// Weights of the footprint: cap and film are paraboloids 1 - (r/R)^2, each normalised by its own sum; then
/// low ground is preferred: each share is weighed by 1 + (mean - z) / bias, held within 0 .. 2. Then the
/// liquid is added.
/// Loops over the working arrays alone run over whole vectors; sums take the window's columns.
/// @param u, v the centre in fine cells from the window's corner
template <int kWidth>
FIRN_INLINE void spread(const FieldWindow& w, Work<kWidth>& work, const DropletParams& p, double depth_cells,
                        double u, double v, double dx, double dy) {
  const double ic = 1.0 / (p.cap_radius_mm * p.cap_radius_mm),
               fc = 1.0 / (p.film_radius_mm * p.film_radius_mm);
  double rx2[kWidth], cap_column[kWidth] = {}, film_column[kWidth] = {}, column[kWidth] = {};
  const int whole = (w.nx + 3) / 4 * 4;
  for (int a = 0; a < whole; ++a) {
    const double r = (a + 0.5 - u) * dx;
    rx2[a] = r * r;
  }
  for (int b = 0; b < w.ny; ++b) {
    const double r = (b + 0.5 - v) * dy, ry2 = r * r;
    double* cap = work.weight[b];
    double* film = work.other[b];
    for (int a = 0; a < whole; ++a) {
      const double r2 = rx2[a] + ry2, c = 1.0 - r2 * ic, f = 1.0 - r2 * fc;
      cap[a] = c > 0.0 ? c : 0.0;
      film[a] = f > 0.0 ? f : 0.0;
      cap_column[a] += cap[a];
      film_column[a] += film[a];
    }
  }
  double cap_sum = 0.0, film_sum = 0.0;
  for (int a = 0; a < w.nx; ++a) {
    cap_sum += cap_column[a];
    film_sum += film_column[a];
  }
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
  for (int a = 0; a < w.nx; ++a) {
    mean += column[a];
    column[a] = 0.0;
  }
  const double steepness = 1.0 / p.slope_bias_mm;
  for (int b = 0; b < w.ny; ++b) {
    double* weight = work.weight[b];
    const double* z = work.other[b];
    for (int a = 0; a < whole; ++a) {
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
FIRN_INLINE void level(const FieldWindow& w, Work<kWidth>& work, double rate, double run_share) {
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
FIRN_INLINE void land_in(const FieldWindow& w, const DropletParams& p, double depth_cells, double u, double v,
                         double dx, double dy) {
  Work<kWidth> work;
  spread(w, work, p, depth_cells, u, v, dx, dy);
  for (int n = 0; n < p.levelling_steps; ++n) level(w, work, p.levelling, p.run_share);
}

FIRN_INLINE void land_body(const FieldWindow& w, const DropletParams& p, double depth_cells, double u,
                           double v, double dx, double dy) {
  if (w.nx <= 16 && w.ny <= 16)
    land_in<16>(w, p, depth_cells, u, v, dx, dy);
  else
    land_in<kMaxFootprint>(w, p, depth_cells, u, v, dx, dy);
}

void land_portable(const FieldWindow& w, const DropletParams& p, double depth_cells, double u, double v,
                   double dx, double dy) {
  land_body(w, p, depth_cells, u, v, dx, dy);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void land_avx2(const FieldWindow& w, const DropletParams& p,
                                               double depth_cells, double u, double v, double dx, double dy) {
  land_body(w, p, depth_cells, u, v, dx, dy);
}
#endif

}  // namespace

Footprint portable_footprint() { return &land_portable; }

Footprint footprint() {
#if defined(__x86_64__)
  static const bool avx2 = __builtin_cpu_supports("avx2");
  if (avx2) return &land_avx2;
#endif
  return &land_portable;
}

}  // namespace firn::plant
