#include "procs/scheduler/rise_evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/deposition/offset_change.h"

namespace firn {
namespace {

constexpr double kEdge_layers = 2.0;         // ground so much lower beside a cell draws its ink away
constexpr double kNoiseIfUnknown_mm = 1e-3;  // [Lu 2015, V-B]
constexpr int kShared_cells = 8;             // 2 mm of a profile, over which its noise may be correlated

double variance(double std_mm) {
  const double s = std_mm > 0.0 ? std_mm : kNoiseIfUnknown_mm;
  return s * s;
}

/// Ground whose cells scatter alike between two scans.
enum Ground : std::size_t { kLevel, kTop, kFoot };  // of a wall
constexpr std::size_t kGrounds = 3;
using Ratios = std::array<double, kGrounds>;

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

/// Returns the share of the expected rise that a cell with droplets shows at least: 1 on level ground. Ink
/// runs off the part where the ground beside a cell is two layers lower: there a droplet that is alone may
/// add nothing, and droplets of a full layer hold each other. Beyond the map's border is the bare table:
/// where the cell stands two layers above it, ink near the border may leave the map, but for droplets
/// that are held all round.
double held_share(const HeightMap& before, const DropletPattern& drops, int i, int j, double fall_mm) {
  const GridSpec& g = before.spec;
  const int border = std::min(std::min(i, j), std::min(g.nx - 1 - i, g.ny - 1 - j));
  const bool leaves = border < RiseEvidence::kWide_cells && before.at(i, j) > fall_mm;
  bool edge = leaves && border == 0, alone = false;
  for (int y = std::max(0, j - 1); y <= std::min(g.ny - 1, j + 1); ++y)
    for (int x = std::max(0, i - 1); x <= std::min(g.nx - 1, i + 1); ++x) {
      const bool lower = before.at(x, y) < before.at(i, j) - fall_mm;
      edge = edge || lower;
      alone = alone || (!lower && drops.at(x, y) == 0);
    }
  return !edge && !leaves ? 1.0 : alone ? 0.0 : edge ? RiseEvidence::kEdgeShare : 1.0;
}

Material ink_of(const RiseEvidence::Layer& l, std::size_t c) {
  return l.materials.cells.empty() ? Material::kA : l.materials.of(c);
}

/// The inks of each cell's droplets and of those up to `reach` cells away: a bit each.
std::vector<std::uint8_t> inks_near(const RiseEvidence::Layer& l, int reach) {
  const GridSpec& g = l.drops.spec;
  std::vector<std::uint8_t> along_x(g.size()), near(g.size());
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (l.drops.cells[c] == 0) continue;
      const auto bit = std::uint8_t(ink_of(l, c) == Material::kB ? 2 : 1);
      for (int x = std::max(0, i - reach); x <= std::min(g.nx - 1, i + reach); ++x)
        along_x[g.index(x, j)] |= bit;
    }
  for (int j = 0; j < g.ny; ++j)
    for (int y = std::max(0, j - reach); y <= std::min(g.ny - 1, j + reach); ++y)
      for (int i = 0; i < g.nx; ++i) near[g.index(i, j)] |= along_x[g.index(i, y)];
  return near;
}

using Rise = std::vector<double>;  // of each cell [mm]

/// Rise of each cell on flat ground by either ink of the droplets on cells that `counts` has above 0.
std::array<Rise, 2> expected_rise(const Experiment& e, const RiseEvidence::Layer& l, const Rise& counts) {
  const ModelConfig& m = e.model;
  const OffsetTable places(e.actuation);
  const deposition::DropletModel a{m.h1_mm, m.h2_mm, m.h3_mm}, b{m.g1_mm, m.g2_mm, m.g3_mm};
  const deposition::OffsetModel inks[2] = {offset_model(a, places, e.actuation.heights_mm),
                                           offset_model(b, places)};
  const int radius = places.size() > 1 ? deposition::OffsetKernel::kRadius : 1;
  const GridSpec& g = l.drops.spec;
  std::array<Rise, 2> rise{Rise(g.size()), Rise(g.size())};
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      if (l.drops.cells[c] == 0 || !(counts[c] > 0.0)) continue;
      const std::size_t ink = ink_of(l, c) == Material::kB;
      const deposition::OffsetKernel& k = inks[ink].kernels[std::size_t(l.offsets.of(c))];
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
          if (g.contains(i + dx, j + dy))
            rise[ink][g.index(i + dx, j + dy)] += l.drops.cells[c] * k.at(dx, dy);
    }
  return rise;
}

/// Means of `count` values at a distance of `step` over `reach` to either side; nothing lies beyond the ends.
void spread_line(double* first, std::size_t step, int count, int reach, Rise& sums) {
  sums.assign(std::size_t(count) + 1, 0.0);
  for (int n = 0; n < count; ++n)
    sums[std::size_t(n) + 1] = sums[std::size_t(n)] + first[std::size_t(n) * step];
  for (int n = 0; n < count; ++n)
    first[std::size_t(n) * step] =
        (sums[std::size_t(std::min(count, n + reach + 1))] - sums[std::size_t(std::max(0, n - reach))]) /
        (2 * reach + 1);
}

/// Mean over the square of cells within `reach`.
Rise spread_evenly(const GridSpec& g, Rise rise, int reach) {
  Rise sums;
  for (int j = 0; j < g.ny; ++j) spread_line(&rise[g.index(0, j)], 1, g.nx, reach, sums);
  for (int i = 0; i < g.nx; ++i) spread_line(&rise[g.index(i, 0)], std::size_t(g.nx), g.ny, reach, sums);
  return rise;
}

/// Sums of (x - e) / sqrt(v) over cells of one kind.
class Scatter {
 public:
  void add(double z) {
    ++n_;
    sum_ += z;
    squares_ += z * z;
  }
  /// The variance about the mean of its own kind, over the cells of all kinds; at least 1.
  static double birge_ratio(std::span<const Scatter> kinds) {
    double squares = 0.0, free = 0.0;
    for (const Scatter& g : kinds) {
      if (g.n_ < 2.0) continue;
      squares += g.squares_ - g.sum_ * g.sum_ / g.n_;
      free += g.n_ - 1.0;
    }
    return free == 0.0 ? 1.0 : std::max(1.0, squares / free);
  }

 private:
  double n_ = 0.0, sum_ = 0.0, squares_ = 0.0;
};

struct Cell {
  int i, j;
  Ground ground;
  double rise_mm, expected_mm, counted_mm, variance_mm2;
};

/// Calls f(first, end) for each stretch of cells with the same key.
template <class Key, class F>
void each_stretch(const std::vector<Cell>& cells, Key key, F f) {
  for (std::size_t first = 0, end = 0; first < cells.size(); first = end) {
    while (end < cells.size() && key(cells[end]) == key(cells[first])) ++end;
    f(first, end);
  }
}
std::int64_t row_of(const Cell& c) { return c.j; }
std::int64_t stretch_of(const Cell& c) { return std::int64_t(c.j) * 1'000'000 + c.i / kShared_cells; }

/// The variances of the errors that the cells of a row, and those of a stretch of kShared_cells of it, have
/// in common [mm^2], by the scatter of their means about a + b e.
struct SharedErrors {
  double row_mm2 = 0.0, stretch_mm2 = 0.0;

  SharedErrors(const std::vector<Cell>& cells, const Ratios& ratios) {
    const auto weight = [&](const Cell& c) { return 1.0 / (ratios[c.ground] * c.variance_mm2); };
    double w = 0.0, e = 0.0, x = 0.0, ee = 0.0, ex = 0.0;
    for (const Cell& c : cells) {
      const double k = weight(c);
      w += k;
      e += k * c.expected_mm;
      x += k * c.rise_mm;
      ee += k * c.expected_mm * c.expected_mm;
      ex += k * c.expected_mm * c.rise_mm;
    }
    const double spread = ee - e * e / w, b = spread > 1e-12 * ee ? (ex - e * x / w) / spread : 0.0,
                 a = (x - b * e) / w;
    const auto shared = [&](auto key) {  // of DerSimonian and Laird
      double q = 0.0, groups = 0.0, weights = 0.0;
      each_stretch(cells, key, [&](std::size_t first, std::size_t end) {
        double sum = 0.0, own = 0.0;
        for (std::size_t n = first; n < end; ++n) {
          own += weight(cells[n]);
          sum += weight(cells[n]) * (cells[n].rise_mm - a - b * cells[n].expected_mm);
        }
        q += sum * sum / own;
        weights += own;
        ++groups;
      });
      return groups > 2.0 ? std::max(0.0, (q - (groups - 2.0)) / weights) : 0.0;
    };
    row_mm2 = shared(row_of);
    stretch_mm2 = shared(stretch_of);
  }
};

/// Cells that are judged together, row by row.
class Cells {
 public:
  void add(const Cell& cell) { cells_.push_back(cell); }
  const std::vector<Cell>& all() const { return cells_; }
  RiseSum sum(const Ratios& ratios, const SharedErrors& shared) const {
    RiseSum r;
    for (const Cell& c : cells_) {
      const double v = ratios[c.ground] * c.variance_mm2, information = c.counted_mm * c.counted_mm / v;
      r.add({1.0, c.rise_mm, c.expected_mm, v, information, c.counted_mm * c.rise_mm / v, information});
    }
    double of_shares[2] = {}, of_sums[2] = {};
    const auto common = [&](auto key, double mm2, std::size_t which) {
      each_stretch(cells_, key, [&](std::size_t first, std::size_t end) {
        double weights = 0.0;
        for (std::size_t n = first; n < end; ++n)
          weights += cells_[n].counted_mm / (ratios[cells_[n].ground] * cells_[n].variance_mm2);
        of_shares[which] += mm2 * weights * weights;
        of_sums[which] += mm2 * double(end - first) * double(end - first);
      });
    };
    common(row_of, shared.row_mm2, 0);
    common(stretch_of, shared.stretch_mm2, 1);
    r.share_variance += std::max(of_shares[0], of_shares[1]);
    r.variance_mm2 += std::max(of_sums[0], of_sums[1]);
    return r;
  }

 private:
  std::vector<Cell> cells_;
};

}  // namespace

void RiseSum::add(const RiseSum& r) {
  cells += r.cells;
  measured_mm += r.measured_mm;
  expected_mm += r.expected_mm;
  variance_mm2 += r.variance_mm2;
  information += r.information;
  share += r.share;
  share_variance += r.share_variance;
}

bool RiseSum::below(double limit, double sigmas) const {
  return limit * information - share > sigmas * std::sqrt(share_variance);
}
bool RiseSum::above(double limit, double sigmas) const {
  return share - limit * information > sigmas * std::sqrt(share_variance);
}
bool RiseSum::sum_above(double limit, double sigmas) const {
  return measured_mm - limit * expected_mm > sigmas * std::sqrt(variance_mm2);
}

void RiseEvidence::add(const RiseEvidence& e) {
  for (const std::size_t n : {0, 1}) {
    inks[n].own.add(e.inks[n].own);
    inks[n].spread.add(e.inks[n].spread);
    inks[n].wide.add(e.inks[n].wide);
    inks[n].much.add(e.inks[n].much);
    inks[n].reach.add(e.inks[n].reach);
  }
  bare.add(e.bare);
  far.add(e.far);
  whole.add(e.whole);
}

RiseEvidence::RiseEvidence(const Experiment& e, const Layer& l) {
  const GridSpec& g = l.drops.spec;
  const double layer_mm = e.model.h1_mm + 4.0 * e.model.h2_mm + 4.0 * e.model.h3_mm,
               noise_mm2 = variance(l.before_std_mm) + variance(l.std_mm), wall_mm = kEdge_layers * layer_mm;
  const auto scattered_mm2 = [noise_mm2](double e_mm) {
    return noise_mm2 + kScatter * kScatter * e_mm * e_mm;
  };
  const std::vector<std::uint8_t> near = inks_near(l, kNear_cells), not_far = inks_near(l, kFar_cells);
  Rise held(g.size(), 0.0);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      if (const std::size_t c = g.index(i, j); l.drops.cells[c] != 0)
        held[c] = held_share(l.before, l.drops, i, j, wall_mm);
  const std::array<Rise, 2> expected = expected_rise(e, l, Rise(g.size(), 1.0)),
                            evident = expected_rise(e, l, held);
  std::array<Rise, 2> spread, wide;
  for (const std::size_t ink : {0, 1}) {
    spread[ink] = spread_evenly(g, evident[ink], kNear_cells);
    wide[ink] = spread_evenly(g, evident[ink], kWide_cells);
  }
  constexpr std::size_t kEmpty = 2, kBare = 3, kGroups = 4;  // beside cells with droplets of either ink
  struct {
    Cells own, spread, wide, much, reach;
  } of[2];
  Cells bare_cells, far_cells, whole_cells;
  Scatter scatter[kGrounds][kGroups];
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const std::size_t c = g.index(i, j);
      const double rise = l.after.cells[c] - l.before.cells[c];
      if (!std::isfinite(rise)) continue;
      const Ground ground = ground_of(l.before, i, j, wall_mm);
      const double all_mm = expected[0][c] + expected[1][c];
      whole_cells.add({i, j, ground, rise, all_mm, all_mm, scattered_mm2(all_mm)});
      for (const std::size_t ink : {0, 1}) {
        const auto add = [&](Cells& cells, const std::array<Rise, 2>& rises) {
          const double own_mm = rises[ink][c], other_mm = rises[1 - ink][c];
          if (own_mm > 0.0)
            cells.add({i, j, ground, rise - other_mm, own_mm, own_mm, scattered_mm2(own_mm + other_mm)});
        };
        add(of[ink].spread, spread);
        add(of[ink].wide, wide);
      }
      if (near[c] == 0) {
        scatter[ground][kBare].add(rise / std::sqrt(noise_mm2));
        bare_cells.add({i, j, ground, rise, layer_mm, layer_mm, noise_mm2});
        if (not_far[c] == 0) far_cells.add({i, j, ground, rise, layer_mm, layer_mm, noise_mm2});
        continue;
      }
      const std::size_t giver = near[c] == 3 ? expected[1][c] > expected[0][c] : near[c] - 1u,
                        ink = ink_of(l, c) == Material::kB;
      const bool empty = l.drops.cells[c] == 0;
      scatter[ground][empty ? kEmpty : ink].add((rise - all_mm) / std::sqrt(scattered_mm2(all_mm)));
      const double much_mm2 = scattered_mm2(e.process.most_rise_share * all_mm);
      of[giver].reach.add({i, j, ground, rise, all_mm, all_mm, much_mm2});
      if (empty) continue;
      of[ink].much.add({i, j, ground, rise, all_mm, all_mm, much_mm2});
      const double own_mm = expected[ink][c];
      of[ink].own.add(
          {i, j, ground, rise - expected[1 - ink][c], own_mm, own_mm * held[c], scattered_mm2(own_mm)});
    }
  Ratios ratios{};
  for (const std::size_t ground : {kLevel, kTop, kFoot})
    ratios[ground] = Scatter::birge_ratio(scatter[ground]);
  const SharedErrors shared(whole_cells.all(), ratios);
  const auto sum = [&](const Cells& cells) { return cells.sum(ratios, shared); };
  for (const std::size_t ink : {0, 1})
    inks[ink] = {sum(of[ink].own), sum(of[ink].spread), sum(of[ink].wide), sum(of[ink].much),
                 sum(of[ink].reach)};
  bare = sum(bare_cells);
  far = sum(far_cells);
  whole = sum(whole_cells);
}

}  // namespace firn
