#include "plant/ice/table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace firn::plant {
namespace {

constexpr double kUnevenness_mm = 80.0;

// Weights of three neighbours of a lattice at a fraction -0.5 .. 0.5 from the middle one.
std::array<double, 3> spline(double f) {
  return {0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)};
}

// Mean over all places of the sum of the squared weights, in one dimension.
constexpr double kVariance = 0.55;

double lattice(const PatternKey& key, std::int64_t a, std::int64_t b) {
  return random_normal(
      {key.seed, key.purpose, key.layer, std::uint32_t(a + (1 << 20)), std::uint32_t(b + (1 << 20))});
}

// Lagrange through -1, 0, 1.
std::array<double, 3> quadratic(double u) { return {0.5 * u * (u - 1.0), 1.0 - u * u, 0.5 * u * (u + 1.0)}; }

}  // namespace

double table_height_mm(const IceTableParams& p, std::uint64_t seed, double x_mm, double y_mm) {
  const double u = 2.0 * (x_mm - p.centre_x_mm) / p.width_mm, v = 2.0 * (y_mm - p.centre_y_mm) / p.depth_mm;
  if (std::abs(u) > 1.0 || std::abs(v) > 1.0) return -1000.0;
  double z = 0.25 * ((1 - u) * (1 - v) * p.foot_mm[0] + (1 + u) * (1 - v) * p.foot_mm[1] +
                     (1 - u) * (1 + v) * p.foot_mm[2] + (1 + u) * (1 + v) * p.foot_mm[3]);
  const auto wu = quadratic(u), wv = quadratic(v);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t a = 0; a < 3; ++a) z += wu[a] * wv[b] * p.screw_mm[3 * b + a];
  if (p.roughness_mm > 0.0) {
    const double s = x_mm / kUnevenness_mm, t = y_mm / kUnevenness_mm;
    const auto a = std::int64_t(std::floor(s + 0.5)), b = std::int64_t(std::floor(t + 0.5));
    const auto ws = spline(s - double(a)), wt = spline(t - double(b));
    double sum = 0.0;
    for (std::int64_t n = 0; n < 3; ++n)
      for (std::int64_t m = 0; m < 3; ++m)
        sum += ws[std::size_t(m)] * wt[std::size_t(n)] *
               lattice({seed, Purpose::kDisturbance, 7}, a + m - 1, b + n - 1);
    z += p.roughness_mm / kVariance * sum;
  }
  for (const IceJig& jig : p.jigs)
    if (x_mm >= jig.x0_mm && x_mm <= jig.x1_mm && y_mm >= jig.y0_mm && y_mm <= jig.y1_mm)
      return z + jig.top_mm;
  return z;
}

void add_lattice_noise(const PatternKey& key, double length_mm, double sigma, double cell_mm, int nx, int ny,
                       std::vector<float>& into) {
  if (sigma <= 0.0) return;
  const int la = int(nx * cell_mm / length_mm) + 4, lb = int(ny * cell_mm / length_mm) + 4;
  std::vector<float> nodes(std::size_t(la) * std::size_t(lb));
  for (int b = 0; b < lb; ++b)
    for (int a = 0; a < la; ++a)
      nodes[std::size_t(b) * std::size_t(la) + std::size_t(a)] =
          float(sigma / kVariance * lattice(key, a, b));
  std::vector<float> row(static_cast<std::size_t>(la));
  for (int j = 0; j < ny; ++j) {
    const double t = (j + 0.5) * cell_mm / length_mm + 1.0;
    const int b = int(t + 0.5);
    const auto wt = spline(t - b);
    for (int a = 0; a < la; ++a) {
      const auto at = [&](int n) { return nodes[std::size_t(b + n) * std::size_t(la) + std::size_t(a)]; };
      row[std::size_t(a)] = float(wt[0]) * at(-1) + float(wt[1]) * at(0) + float(wt[2]) * at(1);
    }
    for (int i = 0; i < nx; ++i) {
      const double s = (i + 0.5) * cell_mm / length_mm + 1.0;
      const int a = int(s + 0.5);
      const auto ws = spline(s - a);
      into[std::size_t(j) * std::size_t(nx) + std::size_t(i)] += float(ws[0]) * row[std::size_t(a - 1)] +
                                                                 float(ws[1]) * row[std::size_t(a)] +
                                                                 float(ws[2]) * row[std::size_t(a + 1)];
    }
  }
}

}  // namespace firn::plant
