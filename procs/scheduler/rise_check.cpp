#include "procs/scheduler/rise_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/deposition/offset_change.h"

namespace firn {
namespace {

constexpr double kEdge_layers = 2.0;         // ground so much lower beside a cell draws its ink away
constexpr double kNoiseIfUnknown_mm = 1e-3;  // [Lu 2015, V-B]
constexpr std::size_t kMostLayers = 8;

double variance(double std_mm) {
  const double s = std_mm > 0.0 ? std_mm : kNoiseIfUnknown_mm;
  return s * s;
}

/// Returns the share of the expected rise that a cell with droplets shows at least: 1 on level ground.
double held_share(const HeightMap& before, const DropletPattern& drops, int i, int j, double fall_mm) {
  const GridSpec& g = before.spec;
  bool edge = false, alone = false;
  for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1); ++y)
    for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x) {
      const bool lower = before.at(x, y) < before.at(i, j) - fall_mm;
      edge = edge || lower;
      alone = alone || (!lower && drops.at(x, y) == 0);
    }
  return !edge ? 1.0 : alone ? 0.0 : RiseCheck::kEdgeShare;
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

/// Rise of each cell by either ink on flat ground, of droplets beside the centres.
std::vector<std::array<double, 2>> expected_rise(const Experiment& e, const RiseCheck::Layer& l) {
  const ModelConfig& m = e.model;
  const OffsetTable places(e.actuation);
  const deposition::DropletModel a{m.h1_mm, m.h2_mm, m.h3_mm}, b{m.g1_mm, m.g2_mm, m.g3_mm};
  const deposition::OffsetModel inks[2] = {offset_model(a, places, e.actuation.heights_mm),
                                           offset_model(b, places)};
  constexpr int kRadius = deposition::OffsetKernel::kRadius;
  const GridSpec& g = l.drops.spec;
  std::vector<std::array<double, 2>> rise(g.size());
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (l.drops.cells[c] == 0) continue;
      const std::size_t ink = !l.materials.cells.empty() && l.materials.of(c) == Material::kB;
      const deposition::OffsetKernel& k = inks[ink].kernels[std::size_t(l.offsets.of(c))];
      for (int dy = -kRadius; dy <= kRadius; ++dy)
        for (int dx = -kRadius; dx <= kRadius; ++dx)
          if (g.contains(i + dx, j + dy))
            rise[g.index(i + dx, j + dy)][ink] += l.drops.cells[c] * k.at(dx, dy);
    }
  return rise;
}

std::string um(double mm) { return std::to_string(mm * 1e3) + " um"; }

}  // namespace

void RiseCheck::Rise::add(const Rise& r) {
  cells += r.cells;
  measured_mm += r.measured_mm;
  expected_mm += r.expected_mm;
  information += r.information;
  share += r.share;
  most_information += r.most_information;
  most_share += r.most_share;
}

RiseCheck::Evidence RiseCheck::evidence_of(const Experiment& e, const Layer& l) {
  const GridSpec& g = l.drops.spec;
  const ModelConfig& m = e.model;
  const double h[2][3] = {{m.h1_mm, m.h2_mm, m.h3_mm}, {m.g1_mm, m.g2_mm, m.g3_mm}};
  const auto ink = [&](std::size_t c) {
    return l.materials.cells.empty() || l.materials.of(c) != Material::kB ? 0 : 1;
  };
  const double layer_mm = h[0][0] + 4.0 * h[0][1] + 4.0 * h[0][2],
               noise_mm2 = variance(l.before_std_mm) + variance(l.std_mm);
  const auto scattered_mm2 = [noise_mm2](double e_mm) {
    return noise_mm2 + kScatter * kScatter * e_mm * e_mm;
  };
  Evidence sum;
  const std::vector<std::uint8_t> near_them = near_droplets(l.drops);
  const auto rises = l.offsets.cells.empty() ? std::vector<std::array<double, 2>>{} : expected_rise(e, l);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = std::size_t(g.index(i, j));
      const double rise = l.after.cells[c] - l.before.cells[c];
      if (!std::isfinite(rise) || (near_them[c] && l.drops.cells[c] == 0)) continue;
      if (!near_them[c]) {
        sum.bare.add({1.0, rise, layer_mm, layer_mm * layer_mm / noise_mm2, layer_mm * rise / noise_mm2});
        continue;
      }
      std::array<double, 2> expected_mm = {};
      if (!rises.empty()) expected_mm = rises[c];
      for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1) && rises.empty(); ++y)
        for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x) {
          const std::size_t n = std::size_t(g.index(x, y));
          expected_mm[std::size_t(ink(n))] += l.drops.cells[n] * h[ink(n)][std::abs(x - i) + std::abs(y - j)];
        }
      const double own_mm = expected_mm[std::size_t(ink(c))], other_mm = expected_mm[std::size_t(1 - ink(c))],
                   all_mm = own_mm + other_mm,
                   least_mm = own_mm * held_share(l.before, l.drops, i, j, kEdge_layers * layer_mm),
                   v = scattered_mm2(own_mm), most_v = scattered_mm2(e.process.most_rise_share * all_mm);
      sum.of_ink[std::size_t(ink(c))].add({1.0, rise, all_mm, least_mm * least_mm / v,
                                           least_mm * (rise - other_mm) / v, all_mm * all_mm / most_v,
                                           all_mm * rise / most_v});
    }
  return sum;
}

Violation RiseCheck::judge(const ProcessConfig& process, const Evidence& sum, int layers) {
  const double least = process.least_rise_share, most = process.most_rise_share;
  const std::string where = layers == 1 ? "" : "in the last " + std::to_string(layers) + " layers ";
  for (const int n : {0, 1}) {
    const Rise& r = sum.of_ink[std::size_t(n)];
    if (r.cells == 0.0) continue;
    const std::string what = std::string(n ? "jet_b: " : "jet: ") + where + std::to_string(int(r.cells)) +
                             " cells with its droplets rose by " + um(r.measured_mm / r.cells) +
                             " on average, " + um(r.expected_mm / r.cells) + " is expected: ";
    const double share = r.measured_mm / r.expected_mm;
    if (least > 0.0 && least * r.information - r.share > kSigmas * std::sqrt(r.information))
      return {what + "drops without rise, the nozzle is dead",
              {share, least, "", "process.least_rise_share"}};
    if (r.most_share - most * r.most_information > kSigmas * std::sqrt(r.most_information))
      return {what + "rise without drops, it gives too much", {share, most, "", "process.most_rise_share"}};
  }
  const Rise& bare = sum.bare;
  if (least > 0.0 && bare.share - least * bare.information > kSigmas * std::sqrt(bare.information))
    return {where + std::to_string(int(bare.cells)) + " cells without a droplet near rose by " +
                um(bare.measured_mm / bare.cells) + " on average: rise without drops, a nozzle leaks",
            {bare.measured_mm / bare.cells * 1e3, least * bare.expected_mm / bare.cells * 1e3, "um",
             "process.least_rise_share"}};
  return {};
}

Violation RiseCheck::check(const Experiment& e, const Layer& layer) {
  if (layer.before.spec != layer.drops.spec || layer.after.spec != layer.drops.spec) return {};
  layers_.push_front(evidence_of(e, layer));
  if (layers_.size() > kMostLayers) layers_.pop_back();
  Evidence sum;
  for (std::size_t n = 1; n <= layers_.size(); ++n) {
    const Evidence& last = layers_[n - 1];
    for (const std::size_t k : {0, 1}) sum.of_ink[k].add(last.of_ink[k]);
    sum.bare.add(last.bare);
    if ((n & (n - 1)) != 0) continue;  // 1, 2, 4, 8
    if (Violation what = judge(e.process, sum, int(n)); !what.empty()) return what;
  }
  return {};
}

}  // namespace firn
