#include "core/control/pattern.h"

#include <algorithm>

#include "core/grid/random.h"
#include "core/options/require.h"

namespace firn::control {
namespace {

constexpr std::string_view kWhere = "pattern";

bool on_mask(const Mask& mask, int i0, int j0, int i1, int j1) {
  for (int j = j0; j <= j1; ++j)
    for (int i = i0; i <= i1; ++i)
      if (!mask.spec.contains(i, j) || !mask.at(i, j)) return false;
  return true;
}

constexpr int kSideX[] = {1, -1, 0, 0};
constexpr int kSideY[] = {0, 0, 1, -1};
constexpr int kCornerX[] = {1, -1, -1, 1};
constexpr int kCornerY[] = {1, 1, -1, -1};

}  // namespace

std::vector<IdentificationSite> identification_sites(const Mask& mask, int spacing, int layers) {
  std::vector<IdentificationSite> sites;
  int row = 0;
  for (int j = spacing / 2; j < mask.spec.ny; j += spacing, ++row)
    for (int i = spacing / 2; i < mask.spec.nx; i += spacing) {
      if (!on_mask(mask, i - 1, j - 1, i + 1, j + 1)) continue;
      const int n = int(sites.size());
      sites.push_back({i, j, IdentificationSite::Kind((n + row) % 3), n / 3 % 4, 1 + n / 3 % layers});
    }
  return sites;
}

std::vector<SquareSite> square_sites(const Mask& mask, int largest, int step, int spacing) {
  std::vector<SquareSite> sites;
  const int band = (largest - 1) * step + 1 + spacing;
  int next = 1;  // goes on from band to band, so that every size occurs in all places
  for (int j = spacing; j + band <= mask.spec.ny + 1; j += band)
    for (int i = spacing; i < mask.spec.nx;) {
      const SquareSite site{i, j, next, step};
      const int last = site.side_cells() - 1;
      if (i + last + spacing >= mask.spec.nx) break;
      if (!on_mask(mask, i, j, i + last, j + last)) {
        ++i;
        continue;
      }
      sites.push_back(site);
      i += last + 1 + spacing;
      next = next % largest + 1;
    }
  return sites;
}

std::vector<PlaceSite> place_sites(const Mask& mask, int spacing, int places, int layers) {
  std::vector<PlaceSite> sites;
  int row = 0;
  for (int j = spacing / 2; j < mask.spec.ny; j += spacing) {
    const std::size_t before = sites.size();
    for (int i = spacing / 2; i < mask.spec.nx; i += spacing)
      if (on_mask(mask, i - 2, j - 2, i + 2, j + 2))
        sites.push_back({i, j, row % places, 1 + int(sites.size() - before) % layers});
    row += sites.size() > before;
  }
  return sites;
}

PatternPrint::PatternPrint(const Setup& setup, const ControlOptions& options)
    : setup_(setup), options_(options.pattern), predict_(setup), layers_(options.pattern.layers) {
  const PatternOptions& o = options_;
  require(!setup.geometry, kWhere, "patterns to learn from are printed of one ink, without a geometry");
  check_options(kWhere, kPatternOptions, o);
  if (layers_ == 0) {
    double highest_mm = 0.0;
    for (std::size_t c = 0; c < setup.mask.size(); ++c)
      if (setup.mask.cells[c]) highest_mm = std::max(highest_mm, setup.target.cells[c]);
    layers_ = std::max(1, int(highest_mm / setup.model.layer_height_mm() + 0.5));
  }
  if (o.kind == PatternKind::kIdentification) {
    sites_ = identification_sites(setup.mask, o.spacing_cells, layers_);
    layers_ = std::min(layers_, int(sites_.size() + 2) / 3);  // no layer without a site
    require(!sites_.empty(), kWhere, "the part has no room for one identification site of 3 x 3 cells");
    if (on(o.one_by_one)) layers_ *= kSiteDroplets;
  } else if (o.kind == PatternKind::kSquares) {
    squares_ = square_sites(setup.mask, o.largest_square, o.square_step, o.spacing_cells);
    require(!squares_.empty(), kWhere,
            "the part has no room for one square and its margin of " + std::to_string(o.spacing_cells) +
                " cells");
  } else if (o.kind == PatternKind::kPlaces) {
    require(o.spacing_cells >= 5, kWhere,
            "pattern.spacing_cells = " + std::to_string(o.spacing_cells) +
                ": droplets at places are alone in 5 x 5 cells");
    places_ = place_sites(setup.mask, o.spacing_cells, setup.offsets.table.size(), layers_);
    require(!places_.empty(), kWhere, "the part has no room for one droplet alone in 5 x 5 cells");
  }
}

// The centre first; one by one, droplet n of every site is layer n of its five.
void PatternPrint::add_sites(int layer, DropletPattern& drops) const {
  const bool one_by_one = on(options_.one_by_one);
  const int of_sites = one_by_one ? 1 + (layer - 1) / kSiteDroplets : layer;
  const auto add = [&, next = (layer - 1) % kSiteDroplets](int droplet, int i, int j) {
    if (!one_by_one || droplet == next) drops.at(i, j) = 1;
  };
  for (const IdentificationSite& s : sites_) {
    if (s.layer != of_sites) continue;
    add(0, s.i, s.j);
    for (int n = 0; n < 4 && s.kind == IdentificationSite::Kind::kSide; ++n)
      add(1 + n, s.i + kSideX[n], s.j + kSideY[n]);
    if (s.kind == IdentificationSite::Kind::kCorner)
      add(1, s.i + kCornerX[s.corner], s.j + kCornerY[s.corner]);
  }
}

DropletPattern PatternPrint::pattern(int layer) const {
  DropletPattern drops(setup_.grid);
  if (options_.kind == PatternKind::kRandom)
    for (std::size_t c = 0; c < drops.size(); ++c)
      drops.cells[c] =
          setup_.mask.cells[c] && random_uniform({options_.seed, Purpose::kPattern, std::uint32_t(layer), 0,
                                                  std::uint32_t(c)}) < options_.fill;
  add_sites(layer, drops);
  for (const SquareSite& s : squares_)
    for (int y = 0; y < s.n; ++y)
      for (int x = 0; x < s.n; ++x) drops.at(s.i + x * s.step, s.j + y * s.step) = 1;
  for (const PlaceSite& s : places_)
    if (s.layer == layer) drops.at(s.i, s.j) = 1;
  return drops;
}

OffsetMap PatternPrint::places(int layer) const {
  const auto count = std::uint32_t(setup_.offsets.table.size());
  OffsetMap map;
  if (count == 1 || layer > layers_) return map;
  map = OffsetMap(setup_.grid);
  for (std::size_t c = 0; c < map.size() && options_.kind == PatternKind::kRandom; ++c)
    map.cells[c] = std::uint8_t(
        random_below({options_.seed, Purpose::kPattern, std::uint32_t(layer), 1, std::uint32_t(c)}, count));
  for (const PlaceSite& s : places_)
    if (s.layer == layer) map.at(s.i, s.j) = std::uint8_t(s.place);
  return map;
}

Decision PatternPrint::decide(const Measurement& m) {
  check(m, setup_);
  Decision d;
  const int layer = m.layer + 1;
  d.kind = layer <= layers_ ? Decision::Kind::kPrint : Decision::Kind::kEnd;
  d.drops = layer <= layers_ ? pattern(layer) : DropletPattern(setup_.grid);
  d.offsets = places(layer);
  d.reason = layer <= layers_ ? "pattern " + std::to_string(layer) + " of " + std::to_string(layers_)
                              : "all " + std::to_string(layers_) + " patterns are printed";
  predict_.score(d, known_heights(m), 1.0);
  return d;
}

}  // namespace firn::control
