#include "plant/inkjet/footprint.h"

#include "core/grid/avx2.h"

namespace firn::plant {
namespace {

constexpr double kWall_mm = 1e9;

/// Working arrays of one footprint, rows of kWidth cells.
template <int kWidth>
struct Work {
  double weight[kWidth][kWidth], other[kWidth][kWidth];
};

/// The same between walls, which give nothing and take nothing.
template <int kWidth>
struct Walled {
  static constexpr int kMargin = 4;  // columns before the first cell and after the last
  double z[kWidth][kWidth + 2 * kMargin], give[kWidth][kWidth + 2 * kMargin];
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

/// Flow from a cell to its neighbour in one step, at most the liquid that either gives.
FIRN_INLINE double flow(double rate, double from_z, double to_z, double from_gives, double to_gives) {
  double q = rate * (from_z - to_z);
  q = q < from_gives ? q : from_gives;
  return q > -to_gives ? q : -to_gives;
}

/// One levelling step: flows from the old heights, then all exchanges, so that the result does not depend on
/// the order of cells. run_share <= 1/4 keeps every cell's liquid >= 0. Cells beside the window are walls.
template <int kWidth>
FIRN_INLINE void level(const FieldWindow& w, Walled<kWidth>& work, double rate, double run_share) {
  constexpr int kLeft = Walled<kWidth>::kMargin;
  const int whole = (w.nx + 3) / 4 * 4;
  for (int b = 0; b < w.ny; ++b) {
    double* z = work.z[b] + kLeft;
    double* give = work.give[b] + kLeft;
    const double* solid = w.solid + b * w.stride;
    const double* liquid = w.liquid + b * w.stride;
    for (int a = 0; a < w.nx; ++a) {
      z[a] = solid[a] + liquid[a];
      give[a] = run_share * liquid[a];
    }
    for (int a = w.nx; a <= whole; ++a) {
      z[a] = kWall_mm;
      give[a] = 0.0;
    }
    z[-1] = kWall_mm;
    give[-1] = 0.0;
  }
  double from_below[kWidth] = {}, net[kWidth];
  for (int b = 0; b < w.ny; ++b) {
    const double* z = work.z[b] + kLeft;
    const double* give = work.give[b] + kLeft;
    // Left and right are computed for either cell: sums over shifted columns would wait for their stores.
    for (int a = 0; a < whole; ++a) {
      net[a] = 0.0 - flow(rate, z[a], z[a + 1], give[a], give[a + 1]);
      net[a] += flow(rate, z[a - 1], z[a], give[a - 1], give[a]);
      net[a] += from_below[a];
    }
    if (b + 1 < w.ny) {
      const double* above = work.z[b + 1] + kLeft;
      const double* above_gives = work.give[b + 1] + kLeft;
      for (int a = 0; a < whole; ++a) {
        from_below[a] = flow(rate, z[a], above[a], give[a], above_gives[a]);
        net[a] -= from_below[a];
      }
    }
    double* liquid = w.liquid + b * w.stride;
    for (int a = 0; a < w.nx; ++a) liquid[a] += net[a];
  }
}

template <int kWidth>
FIRN_INLINE void land_in(const FieldWindow& w, const DropletParams& p, double depth_cells, double u, double v,
                         double dx, double dy) {
  union {  // one after the other
    Work<kWidth> work;
    Walled<kWidth> walled;
  };
  spread(w, work, p, depth_cells, u, v, dx, dy);
  for (int n = 0; n < p.levelling_steps; ++n) level(w, walled, p.levelling, p.run_share);
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
  if (has_avx2()) return &land_avx2;
#endif
  return &land_portable;
}

}  // namespace firn::plant
