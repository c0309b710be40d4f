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

/// Ground whose cells scatter alike between two scans.
enum Ground : std::size_t { kLevel, kTop, kFoot };  // of a wall
constexpr std::size_t kGrounds = 3;

Ground ground_of(const HeightMap& before, int i, int j, double wall_mm) {
  const GridSpec& g = before.spec;
  Ground ground = kLevel;
  for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1); ++y)
    for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x) {
      if (before.at(x, y) < before.at(i, j) - wall_mm) return kTop;
      if (before.at(x, y) > before.at(i, j) + wall_mm) ground = kFoot;
    }
  return ground;
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

using Inks = std::array<double, 2>;

Material ink_of(const RiseCheck::Layer& l, std::size_t c) {
  return l.materials.cells.empty() ? Material::kA : l.materials.of(c);
}

/// The inks of each cell's droplets and of those up to two cells away: a bit each.
std::vector<std::uint8_t> inks_near(const RiseCheck::Layer& l) {
  const GridSpec& g = l.drops.spec;
  std::vector<std::uint8_t> along_x(g.size()), near(g.size());
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (l.drops.cells[c] == 0) continue;
      const auto bit = std::uint8_t(ink_of(l, c) == Material::kB ? 2 : 1);
      for (int x = std::max(0, i - 2); x <= std::min(g.nx - 1, i + 2); ++x) along_x[g.index(x, j)] |= bit;
    }
  for (int j = 0; j < g.ny; ++j)
    for (int y = std::max(0, j - 2); y <= std::min(g.ny - 1, j + 2); ++y)
      for (int i = 0; i < g.nx; ++i) near[g.index(i, j)] |= along_x[g.index(i, y)];
  return near;
}

/// Rise of each cell by either ink on flat ground.
std::vector<Inks> expected_rise(const Experiment& e, const RiseCheck::Layer& l) {
  const ModelConfig& m = e.model;
  const OffsetTable places(e.actuation);
  const deposition::DropletModel a{m.h1_mm, m.h2_mm, m.h3_mm}, b{m.g1_mm, m.g2_mm, m.g3_mm};
  const deposition::OffsetModel inks[2] = {offset_model(a, places, e.actuation.heights_mm),
                                           offset_model(b, places)};
  const int radius = places.size() > 1 ? deposition::OffsetKernel::kRadius : 1;
  const GridSpec& g = l.drops.spec;
  std::vector<Inks> rise(g.size());
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (l.drops.cells[c] == 0) continue;
      const std::size_t ink = ink_of(l, c) == Material::kB;
      const deposition::OffsetKernel& k = inks[ink].kernels[std::size_t(l.offsets.of(c))];
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
          if (g.contains(i + dx, j + dy))
            rise[g.index(i + dx, j + dy)][ink] += l.drops.cells[c] * k.at(dx, dy);
    }
  return rise;
}

std::string um(double mm) { return std::to_string(mm * 1e3) + " um"; }

}  // namespace

void RiseCheck::Scatter::add(double z) {
  ++n_;
  sum_ += z;
  squares_ += z * z;
}

double RiseCheck::birge_ratio(std::span<const Scatter> groups) {
  double squares = 0.0, free = 0.0;
  for (const Scatter& g : groups) {
    if (g.n_ < 2.0) continue;
    squares += g.squares_ - g.sum_ * g.sum_ / g.n_;
    free += g.n_ - 1.0;
  }
  return free == 0.0 ? 1.0 : std::max(1.0, squares / free);
}

void RiseCheck::Rise::add(const Rise& r) {
  cells += r.cells;
  measured_mm += r.measured_mm;
  expected_mm += r.expected_mm;
  variance_mm2 += r.variance_mm2;
  information += r.information;
  share += r.share;
}

void RiseCheck::Rise::add(const Samples& samples, double ratio) {
  for (const Sample& s : samples) {
    const double v = ratio * s.variance_mm2;
    add({1.0, s.rise_mm, s.expected_mm, v, s.counted_mm * s.counted_mm / v, s.counted_mm * s.rise_mm / v});
  }
}

void RiseCheck::Evidence::add(const Evidence& e) {
  for (const std::size_t ink : {0, 1}) {
    of_ink[ink].add(e.of_ink[ink]);
    much[ink].add(e.much[ink]);
    reach[ink].add(e.reach[ink]);
  }
  bare.add(e.bare);
}

RiseCheck::Evidence RiseCheck::evidence_of(const Experiment& e, const Layer& l) {
  const GridSpec& g = l.drops.spec;
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm,
               noise_mm2 = variance(l.before_std_mm) + variance(l.std_mm), wall_mm = kEdge_layers * layer_mm;
  const auto scattered_mm2 = [noise_mm2](double e_mm) {
    return noise_mm2 + kScatter * kScatter * e_mm * e_mm;
  };
  const std::vector<std::uint8_t> near = inks_near(l);
  const std::vector<Inks> expected = expected_rise(e, l);
  constexpr std::size_t kEmpty = 2, kBare = 3, kGroups = 4;  // beside cells with droplets of either ink
  Samples with_droplet[2][kGrounds], much[2][kGrounds], reached[2][kGrounds], bare[kGrounds];
  Scatter scatter[kGrounds][kGroups];
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      const double rise = l.after.cells[c] - l.before.cells[c];
      if (!std::isfinite(rise)) continue;
      const Ground ground = ground_of(l.before, i, j, wall_mm);
      if (near[c] == 0) {
        scatter[ground][kBare].add(rise / std::sqrt(noise_mm2));
        bare[ground].push_back({rise, layer_mm, layer_mm, noise_mm2});
        continue;
      }
      const double all_mm = expected[c][0] + expected[c][1];
      const std::size_t giver = near[c] == 3 ? expected[c][1] > expected[c][0] : near[c] - 1u,
                        ink = ink_of(l, c) == Material::kB;
      const bool empty = l.drops.cells[c] == 0;
      scatter[ground][empty ? kEmpty : ink].add((rise - all_mm) / std::sqrt(scattered_mm2(all_mm)));
      const Sample much_sample{rise, all_mm, all_mm, scattered_mm2(e.process.most_rise_share * all_mm)};
      reached[giver][ground].push_back(much_sample);
      if (empty) continue;
      much[ink][ground].push_back(much_sample);
      const double own_mm = expected[c][ink];
      with_droplet[ink][ground].push_back({rise - expected[c][1 - ink], own_mm,
                                           own_mm * held_share(l.before, l.drops, i, j, wall_mm),
                                           scattered_mm2(own_mm)});
    }
  Evidence sum;
  for (const std::size_t ground : {kLevel, kTop, kFoot}) {
    const double ratio = birge_ratio(scatter[ground]);
    for (const std::size_t ink : {0, 1}) {
      sum.of_ink[ink].add(with_droplet[ink][ground], ratio);
      sum.much[ink].add(much[ink][ground], ratio);
      sum.reach[ink].add(reached[ink][ground], ratio);
    }
    sum.bare.add(bare[ground], ratio);
  }
  return sum;
}

Violation RiseCheck::judge(const ProcessConfig& process, const Evidence& sum, int layers) {
  const double least = process.least_rise_share, most = process.most_rise_share;
  const std::string where = layers == 1 ? "" : "in the last " + std::to_string(layers) + " layers ";
  for (const std::size_t n : {0, 1}) {
    const Rise& r = sum.of_ink[n];
    if (r.cells == 0.0) continue;
    const auto told = [&](double cells, const char* which, double measured_mm, double expected_mm) {
      return std::string(n ? "jet_b: " : "jet: ") + where + std::to_string(int(cells)) + " cells " + which +
             " its droplets rose by " + um(measured_mm / cells) + " on average, " + um(expected_mm / cells) +
             " is expected: ";
    };
    if (least > 0.0 && least * r.information - r.share > kSigmas * std::sqrt(r.information))
      return {told(r.cells, "with", r.measured_mm, r.expected_mm) + "drops without rise, the nozzle is dead",
              {r.measured_mm / r.expected_mm, least, "", "process.least_rise_share"}};
    const Rise &much = sum.much[n], &reach = sum.reach[n];
    const bool over_cells = much.share - most * much.information > kSigmas * std::sqrt(much.information),
               over_sum =
                   reach.measured_mm - most * reach.expected_mm > kSigmas * std::sqrt(reach.variance_mm2);
    if (over_cells && over_sum)
      return {told(reach.cells, "near", reach.measured_mm, reach.expected_mm) +
                  "rise without drops, it gives too much",
              {reach.measured_mm / reach.expected_mm, most, "", "process.most_rise_share"}};
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
    sum.add(layers_[n - 1]);
    if ((n & (n - 1)) != 0) continue;  // 1, 2, 4, 8
    if (Violation what = judge(e.process, sum, int(n)); !what.empty()) return what;
  }
  return {};
}

}  // namespace firn
