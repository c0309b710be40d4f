#include "core/slice/mesh/slicer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include "core/geometry/planar.h"
#include "core/geometry/rings.h"
#include "core/geometry/turning.h"
#include "core/slice/mesh/path_filter.h"
#include "core/slice/mesh/same_section.h"

namespace firn::slice {
namespace {

constexpr int kLayersAtOnce = 4;

geometry::Rings filtered(const geometry::Rings& rings, PathFilter& filter) {
  geometry::Rings out;
  for (std::size_t r = 0; r < rings.size(); ++r) filter.append(rings[r], out);
  return canonical(out);
}

struct Layer {
  geometry::Region region;
  geometry::Rings from;
  std::vector<Defect> defects;
  std::size_t contours = 0, linked = 0, kept = 0;
  bool repaired = false;
};

Layer finish_layer(Contours&& contours, std::int32_t number, PathFilter& filter, bool all_points,
                   bool spaced) {
  Layer layer;
  layer.defects = std::move(contours.defects);
  layer.contours = contours.rings.size();
  layer.linked = contours.rings.points.size();
  geometry::Rings rings = all_points ? std::move(contours.rings) : filtered(contours.rings, filter);
  layer.kept = rings.points.size();
  if (!all_points && !spaced) layer.from = std::move(contours.rings);
  if (const std::vector<std::size_t> turned = turn_inside_out(rings); !turned.empty()) {
    layer.defects.push_back({DefectKind::kTurned, number, rings[turned[0]][0], 0.0, turned.size()});
    rings = sorted(std::move(rings));
    layer.from.clear();
  }
  std::optional<geometry::Contact> contact;
  layer.region = region_of(rings, &contact);
  if (contact) {
    layer.repaired = true;
    layer.from.clear();
    layer.defects.push_back({DefectKind::kOverlap, number, contact->at, 0.0, 1});
  }
  return layer;
}

// Returns for each layer the first one of those up to it, one on the other, that have the same section. What
// becomes of a layer does not depend on the threads.
std::vector<std::size_t> first_alike(const std::vector<Contours>& contours, const ParallelFor& parallel) {
  std::vector<std::size_t> first(contours.size());
  parallel(int(contours.size()), [&](int n) {
    const auto layer = std::size_t(n);
    const bool alike = layer > 0 && contours[layer].defects.empty() && contours[layer - 1].defects.empty() &&
                       same_section(contours[layer - 1].rings, contours[layer].rings);
    first[layer] = alike ? layer - 1 : layer;
  });
  for (std::size_t n = 1; n < first.size(); ++n) first[n] = first[first[n]];
  return first;
}

void mesh_defects(const MeshFacts& facts, std::vector<Defect>& defects) {
  const auto add = [&](DefectKind kind, std::size_t count) {
    if (count) defects.push_back({kind, 0, {}, 0.0, count});
  };
  add(DefectKind::kNotFinite, facts.not_finite);
  add(DefectKind::kDegenerate, facts.degenerate);
  if (facts.facets) add(DefectKind::kNotClosed, !facts.closed);
  add(DefectKind::kBelow, facts.low.z <= facts.high.z && facts.low.z < 0);
  add(DefectKind::kInsideOut, facts.closed && facts.volume_mm3 < 0.0);
  if (facts.coarse_mm > kCoarse_mm) defects.push_back({DefectKind::kCoarse, 0, {}, facts.coarse_mm, 1});
}

}  // namespace

void check(const SliceOptions& o) {
  check_options("slice", OptionTable{kLayerHeight, kChordTolerance}, o);
  check_options("slice", kContourOptions, o);
}

Sliced regions(std::vector<Contours>&& contours, const MeshFacts& facts, const SliceOptions& options,
               const ParallelFor& parallel) {
  check(options);
  std::vector<Layer> layers(contours.size());
  const bool all_points = options.chord_tolerance_mm == 0.0 && options.min_spacing_mm == 0.0;
  std::vector<std::size_t> first_layer(contours.size());
  if (all_points)
    std::iota(first_layer.begin(), first_layer.end(), std::size_t{0});
  else
    first_layer = first_alike(contours, parallel);
  const auto finish = [&](std::size_t n, PathFilter& filter) {
    layers[n] = finish_layer(std::move(contours[n]), std::int32_t(n) + 1, filter, all_points,
                             options.min_spacing_mm > 0.0);
  };
  const int groups = int((contours.size() + kLayersAtOnce - 1) / kLayersAtOnce);
  const auto each_layer = [&](const auto& use) {
    parallel(groups, [&](int group) {
      PathFilter filter(options.min_spacing_mm * geometry::kUnitsPerMm,
                        options.chord_tolerance_mm * geometry::kUnitsPerMm);
      const std::size_t first = std::size_t(group) * kLayersAtOnce;
      for (std::size_t n = first; n < std::min(first + kLayersAtOnce, contours.size()); ++n) use(n, filter);
    });
  };
  each_layer([&](std::size_t n, PathFilter& filter) {
    if (first_layer[n] == n) finish(n, filter);
  });
  each_layer([&](std::size_t n, PathFilter& filter) {
    const Layer& first = layers[first_layer[n]];
    if (first_layer[n] == n) return;
    if (!first.defects.empty()) return finish(n, filter);  // they name their layer
    layers[n] = first;
    layers[n].linked = contours[n].rings.points.size();
  });
  Sliced out;
  out.facts = facts;
  mesh_defects(facts, out.defects);
  for (std::size_t n = 0; n < layers.size(); ++n) {
    Layer& layer = layers[n];
    out.counts.segments += contours[n].segments;
    out.counts.contours += layer.contours;
    out.counts.linked_points += layer.linked;
    out.counts.kept_points += layer.kept;
    out.counts.repaired_layers += layer.repaired;
    out.defects.insert(out.defects.end(), layer.defects.begin(), layer.defects.end());
    out.layers.push_back(std::move(layer.region));
    out.contours.push_back(std::move(layer.from));
  }
  return out;
}

Sliced slice(const FacetView& facets, const Placement& placement, const SliceOptions& options,
             const ParallelFor& parallel) {
  check(options);
  const Affine affine = place(facets, placement, parallel);
  const std::vector<std::int32_t> planes = layer_planes(options.layer_height_mm, affine.high.z);
  Segments segments = intersect(facets, affine, planes, parallel);
  const MeshFacts facts = segments.facts;
  return regions(link(std::move(segments), options, parallel), facts, options, parallel);
}

void subtract_by_priority(std::span<std::vector<geometry::Region>*> parts, const ParallelFor& parallel) {
  std::size_t layers = 0;
  for (const std::vector<geometry::Region>* part : parts) layers = std::max(layers, part->size());
  parallel(int(layers), [&](int n) {
    geometry::Region before;  // area of the earlier parts
    for (std::vector<geometry::Region>* part : parts) {
      if (std::size_t(n) >= part->size()) continue;
      geometry::Region& mine = (*part)[std::size_t(n)];
      if (mine.empty()) continue;
      if (!before.empty()) mine = subtract(mine, before);
      before = before.empty() ? mine : unite(before, mine);
    }
  });
}

}  // namespace firn::slice
