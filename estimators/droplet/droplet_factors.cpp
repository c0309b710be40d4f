#include "estimators/droplet/droplet_factors.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/options/require.h"

namespace firn::droplet {
namespace {

constexpr double kOutlier_mm =
    5e-3;  // beyond it and beyond half of the expected rise, a droplet did not come

void factors_need(bool ok, std::string_view what) { firn::require(ok, "droplet factors", what); }

}  // namespace

Grid<Place> places_of(const Mask& mask) {
  const GridSpec& g = mask.spec;
  constexpr int kDepth = 3;  // rows of the rim and between
  Grid<std::uint8_t> depth(g, kDepth);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i)
      for (int y = j - kDepth; y <= j + kDepth; ++y)
        for (int x = i - kDepth; x <= i + kDepth; ++x) {
          const int apart = std::max(std::abs(x - i), std::abs(y - j)) - 1;
          if (apart >= 0 && apart < int(depth.at(i, j)) && !(g.contains(x, y) && mask.at(x, y)))
            depth.at(i, j) = std::uint8_t(apart);
        }
  bool has_inside = false;
  for (std::size_t c = 0; c < mask.size(); ++c)
    has_inside = has_inside || (mask.cells[c] && depth.cells[c] == kDepth);
  Grid<Place> place(g, Place::kInside);
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c] && depth.cells[c] < kDepth)
      place.cells[c] = depth.cells[c] == 0 ? Place::kRim : has_inside ? Place::kBetween : Place::kInside;
  return place;
}

DropletFactors::DropletFactors(const GridSpec& grid, const Mask& mask, const DropletFactorOptions& o)
    : grid_(grid),
      options_(o),
      place_(places_of(mask)),
      model_(grid, deposition::stencil_of(o.model), o.border),
      rise_{Grid<double>(grid), Grid<double>(grid), Grid<double>(grid)},
      height_(grid),
      changed_(grid),
      drops_(grid) {
  deposition::check(o.model);
  factors_need(mask.size() == grid.size(), "the mask does not have the grid's size");
  factors_need(o.prior_std > 0.0 && o.cell_std_mm > 0.0, "prior_std and cell_std_mm must be above 0");
  for (const double walk : o.walk_std)
    factors_need(std::isfinite(walk) && walk >= 0.0, "a walk_std must not be below 0");
  factors_need(std::isfinite(o.sparse_std) && o.sparse_std >= 0.0, "sparse_std must not be below 0");
  variance_.fill(o.prior_std * o.prior_std);
  for (std::size_t c = 0; c < mask.size(); ++c)
    if (mask.cells[c]) cells_[std::size_t(place_.cells[c])] += 1.0;
}

void DropletFactors::add_layer(std::span<const double> before, std::span<const Pass> passes,
                               std::span<const double> after, std::span<const Use> use) {
  std::copy(before.begin(), before.end(), height_.cells.begin());
  for (auto& rise : rise_) std::fill(rise.cells.begin(), rise.cells.end(), 0.0);
  for (const Pass& pass : passes) {
    const HeightMap start = height_;
    for (std::size_t k = 0; k < kPlaces; ++k) {
      std::fill(drops_.cells.begin(), drops_.cells.end(), std::uint8_t{0});
      for (const std::uint32_t c : pass.cells) drops_.cells[c] = std::size_t(place_.cells[c]) == k;
      changed_ = start;
      model_.step(changed_.cells.data(), drops_.cells.data(), 0);
      for (std::size_t c = 0; c < start.size(); ++c) {
        const double rise = pass.share * (changed_.cells[c] - start.cells[c]);
        rise_[k].cells[c] += rise;
        height_.cells[c] += factor_[k] * rise;
      }
    }
  }
  std::array<double, kPlaces> model{}, found{}, cells{}, fired{};
  for (const Pass& pass : passes)
    for (const std::uint32_t c : pass.cells) fired[std::size_t(place_.cells[c])] += pass.share;
  for (std::size_t c = 0; c < use.size(); ++c) {
    if (use[c] != Use::kLearn) continue;
    double expected = 0.0;
    for (std::size_t k = 0; k < kPlaces; ++k) expected += factor_[k] * rise_[k].cells[c];
    const double rise = after[c] - before[c], off = std::abs(rise - expected);
    if (off > kOutlier_mm && off > 0.5 * expected) continue;
    const std::size_t k = std::size_t(place_.cells[c]);
    const double own = rise_[k].cells[c];
    model[k] += own;
    found[k] += rise - (expected - factor_[k] * own);
    cells[k] += 1.0;
  }
  for (std::size_t k = 0; k < kPlaces; ++k) {
    variance_[k] += options_.walk_std[k] * options_.walk_std[k];
    if (variance_[k] > options_.prior_std * options_.prior_std)
      variance_[k] = options_.prior_std * options_.prior_std;
    if (!(model[k] > 0.0)) continue;
    double noise = options_.cell_std_mm * options_.cell_std_mm * cells[k] / (model[k] * model[k]);
    if (options_.sparse_std > 0.0 && Place(k) != Place::kRim) {
      const double bare = 1.0 - std::min(1.0, fired[k] / cells_[k]),
                   std = kFullStd + options_.sparse_std * bare * bare;
      noise = std * std;
    }
    const double gain = variance_[k] / (variance_[k] + noise);
    factor_[k] = std::clamp(factor_[k] + gain * (found[k] / model[k] - factor_[k]), kMin, kMax);
    variance_[k] *= 1.0 - gain;
  }
  double& rim = factor_[std::size_t(Place::kRim)];
  rim = std::max(rim, kMinRim * factor_[std::size_t(Place::kInside)]);
}

}  // namespace firn::droplet
