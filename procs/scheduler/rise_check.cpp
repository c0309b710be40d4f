#include "procs/scheduler/rise_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace firn {
namespace {

constexpr double kFewCells = 10.0;
constexpr double kEdge_layers = 2.0;  // ground so much lower beside a cell draws its ink away
constexpr double kEdgeShare = 0.1;    // of the expected rise that counts there

/// Sums over a class of cells [mm]; least_mm: own_mm without the ink that may have run off an edge.
struct Rise {
  double cells = 0.0, measured_mm = 0.0, own_mm = 0.0, other_mm = 0.0, least_mm = 0.0;
};

bool on_edge(const HeightMap& before, int i, int j, double fall_mm) {
  const GridSpec& g = before.spec;
  for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1); ++y)
    for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x)
      if (before.at(x, y) < before.at(i, j) - fall_mm) return true;
  return false;
}

/// Cells with a droplet on them or up to two cells away.
std::vector<std::uint8_t> near_droplets(const DropletPattern& drops) {
  const GridSpec& g = drops.spec;
  std::vector<std::uint8_t> along_x(g.size()), near(g.size());
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      if (drops.at(i, j) == 0) continue;
      for (int x = std::max(0, i - 2); x <= std::min(g.nx - 1, i + 2); ++x) along_x[g.index(x, j)] = 1;
    }
  for (int j = 0; j < g.ny; ++j)
    for (int y = std::max(0, j - 2); y <= std::min(g.ny - 1, j + 2); ++y)
      for (int i = 0; i < g.nx; ++i) near[g.index(i, j)] |= along_x[g.index(i, y)];
  return near;
}

std::string um(double mm) { return std::to_string(mm * 1e3) + " um"; }

}  // namespace

std::string check_rise(const Experiment& e, const HeightMap& before, const HeightMap& after,
                       const DropletPattern& drops, const MaterialMap& materials) {
  const GridSpec& g = drops.spec;
  if (before.spec != g || after.spec != g) return "";
  const double h[2][3] = {{e.model.h1_mm, e.model.h2_mm, e.model.h3_mm},
                          {e.model.g1_mm, e.model.g2_mm, e.model.g3_mm}};
  const auto ink = [&](std::size_t c) {
    return materials.cells.empty() || materials.of(c) != Material::kB ? 0 : 1;
  };
  const double layer_mm = h[0][0] + 4.0 * h[0][1] + 4.0 * h[0][2];
  std::array<Rise, 2> of_ink;
  Rise bare;
  const std::vector<std::uint8_t> near_them = near_droplets(drops);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = std::size_t(g.index(i, j));
      const double rise = after.cells[c] - before.cells[c];
      if (!std::isfinite(rise)) continue;
      double expected_mm[2] = {};
      const bool near = near_them[c] != 0;
      if (near && drops.cells[c] == 0) continue;
      for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1); ++y)
        for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x) {
          const std::size_t n = std::size_t(g.index(x, y));
          expected_mm[ink(n)] += drops.cells[n] * h[ink(n)][std::abs(x - i) + std::abs(y - j)];
        }
      Rise& r = near ? of_ink[std::size_t(ink(c))] : bare;
      r.cells += 1.0;
      r.measured_mm += rise;
      r.own_mm += expected_mm[ink(c)];
      r.least_mm += expected_mm[ink(c)] * (on_edge(before, i, j, kEdge_layers * layer_mm) ? kEdgeShare : 1.0);
      r.other_mm += expected_mm[1 - ink(c)];
    }
  const double least = e.process.least_rise_share, most = e.process.most_rise_share;
  for (const int n : {0, 1}) {
    const Rise& r = of_ink[std::size_t(n)];
    if (r.cells < kFewCells) continue;
    const std::string where = std::string(n ? "jet_b" : "jet") + ": " + std::to_string(int(r.cells)) +
                              " cells with its droplets rose by " + um(r.measured_mm / r.cells) +
                              " on average, " + um((r.own_mm + r.other_mm) / r.cells) + " is expected: ";
    if (r.measured_mm - r.other_mm < least * r.least_mm)
      return where + "drops without rise, the nozzle is dead";
    if (r.measured_mm > most * (r.own_mm + r.other_mm))
      return where + "rise without drops, it gives too much";
  }
  if (bare.cells >= kFewCells && least > 0.0 && bare.measured_mm > least * layer_mm * bare.cells)
    return std::to_string(int(bare.cells)) + " cells without a droplet near rose by " +
           um(bare.measured_mm / bare.cells) + " on average: rise without drops, a nozzle leaks";
  return "";
}

}  // namespace firn
