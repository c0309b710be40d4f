#include "core/slice/paths/path_plan.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/planar.h"
#include "core/slice/medial/gap_fill.h"
#include "core/slice/offset/offset_rings.h"
#include "core/slice/paths/fill_lines.h"
#include "core/slice/paths/hook.h"
#include "core/slice/paths/order.h"

namespace firn::slice {
namespace {

std::int32_t units(double mm) { return std::int32_t(std::lround(mm * geometry::kUnitsPerMm)); }

const ExtrusionOptions& extrusion_of(std::size_t material, const PathOptions& options) {
  return material == kScaffoldMaterial ? options.scaffold : options.part;
}

// Computes extrusion lines where the outline is too narrow for its first ring, and where rings leave voids
// between them.
void find_gaps(const geometry::Region& region, RingLevels& rings, const RingPlan& plan,
               const ExtrusionOptions& extrusion, double tolerance_mm, GapFiller& fill,
               ExtrusionLines& thin_parts, ExtrusionLines& gaps) {
  const geometry::Rings none;
  const auto level = [&](int k) -> const geometry::Rings& {
    return k < 0 ? region : k < int(rings.levels.size()) ? rings.levels[std::size_t(k)] : none;
  };
  for (int k = -1; k + 1 < int(rings.gaps.size()); ++k) {
    LevelGaps& missing = rings.gaps[std::size_t(k + 1)];
    const GapBand band = gap_band(plan, k);
    ExtrusionLines& extrusions = k < 0 ? thin_parts : gaps;
    if (missing.known) {
      fill(missing.of_rings, level(k + 1), band, extrusion.gap_mm, tolerance_mm, extrusions);
      fill(missing.of_eroded_cores, level(k + 1), eroded_core_band(plan, k, extrusion.gap_mm),
           extrusion.gap_mm, tolerance_mm, extrusions);
    } else {
      fill(level(k), level(k + 1), band, extrusion.gap_mm, tolerance_mm,
           k >= 0 && rings.touching[std::size_t(k)], extrusions);
    }
  }
}

// Plans boundaries and fill of one material; the outermost `hooks` levels become hook paths.
void plan_material(const geometry::Region& region, std::uint8_t material, const PathOptions& options,
                   int hooks, geometry::Point& at, LayerPaths& paths, const geometry::Region& part,
                   const Simplified& simplified, PathWork& work) {
  const ExtrusionOptions& extrusion = extrusion_of(material, options);
  const bool rings_only = extrusion.pattern == FillPattern::kConcentric;
  RingPlan plan{extrusion.first_offset_mm, extrusion.boundaries, extrusion.boundary_width_mm,
                extrusion.fill_width_mm};
  if (!rings_only) plan.max_rings = extrusion.boundaries;
  RingLevels rings =
      offset_rings(region, plan, options.chord_tolerance_mm, extrusion.gap_mm, simplified, work.offsets);
  paths.clipper_rings += rings.from_clipper;
  ExtrusionLines thin_parts, gaps;
  if (extrusion.gap_mm > 0)
    find_gaps(region, rings, plan, extrusion, options.chord_tolerance_mm, work.fill_gaps, thin_parts, gaps);
  PathInfo info{PathKind::kHook, kPartMaterial, true, 0};
  for (int level = 0; level < int(rings.levels.size()) && level < hooks; ++level) {
    info.width = units(level < extrusion.boundaries ? extrusion.boundary_width_mm : extrusion.fill_width_mm);
    append_in_order(take_outermost(rings.levels[std::size_t(level)], part), info, options, at, paths);
  }
  const auto append_levels = [&](std::size_t from, std::size_t to, PathKind kind, double width_mm) {
    geometry::Rings lines;
    for (std::size_t level = from; level < std::min(to, rings.levels.size()); ++level)
      for (std::size_t r = 0; r < rings.levels[level].size(); ++r) lines.add(rings.levels[level][r]);
    append_in_order(lines, {kind, material, true, units(width_mm)}, options, at, paths);
  };
  const std::size_t boundaries = std::size_t(extrusion.boundaries);
  append_levels(0, boundaries, PathKind::kBoundary, extrusion.boundary_width_mm);
  append_in_order(thin_parts.lines, {PathKind::kBoundary, material, false, 0}, options, at, paths,
                  thin_parts.widths);
  if (rings_only) append_levels(boundaries, rings.levels.size(), PathKind::kFill, extrusion.fill_width_mm);
  append_in_order(gaps.lines, {PathKind::kFill, material, false, 0}, options, at, paths, gaps.widths);
  if (rings_only) {
    return;
  } else if (extrusion.pattern != FillPattern::kNone) {
    // Lines extend to the line of the innermost boundary: if they ended before it by half their width, strips
    // of up to two widths could remain without a line.
    const double inside_mm =
        plan.distance_mm(plan.boundaries) - (plan.boundaries ? 0.5 * extrusion.fill_width_mm : 0.0);
    const RingPlan inside{.first_mm = inside_mm, .boundaries = 0, .max_rings = 1};
    const RingLevels area =
        offset_rings(region, inside, options.chord_tolerance_mm, 0, simplified, work.offsets);
    paths.clipper_rings += area.from_clipper;
    if (area.levels.empty()) return;
    const double angle = extrusion.fill_angle_rad + (paths.layer % 2 ? 0.0 : extrusion.fill_turn_rad);
    const geometry::Rings lines = extrusion.pattern == FillPattern::kLines
                                      ? fill_lines(area.levels[0], extrusion.fill_width_mm, angle)
                                      : fill_zigzag(area.levels[0], extrusion.fill_width_mm, angle);
    append_in_order(lines, {PathKind::kFill, material, false, units(extrusion.fill_width_mm)}, options, at,
                    paths);
    if (extrusion.gap_mm == 0) return;
    // Narrow parts that no scan line crosses, and corners beside the ends of the lines.
    const geometry::Region open = subtract(area.levels[0], swept_by(lines, 0.5 * extrusion.fill_width_mm));
    if (open.empty()) return;
    ExtrusionLines fingers;
    work.fill_gaps(open, {}, {0.0, 0.5 * extrusion.fill_width_mm}, extrusion.gap_mm,
                   options.chord_tolerance_mm, true, fingers);
    append_in_order(fingers.lines, {PathKind::kFill, material, false, 0}, options, at, paths, fingers.widths);
  }
}

void plan_measurement(const geometry::Region& region, const PathOptions& options, LayerPaths& paths) {
  const MeasureOptions& measure = options.measure;
  RingPlan inside{.first_mm = measure.inset_mm, .boundaries = 0, .max_rings = 1};
  const RingLevels area = offset_rings(region, inside, options.chord_tolerance_mm);
  if (area.levels.empty()) return;
  geometry::Rings lines = fill_lines(area.levels[0], measure.spacing_mm, measure.angle_rad);
  for (geometry::Point& p : lines.points) {
    p.x -= units(measure.laser_x_mm);
    p.y -= units(measure.laser_y_mm);
  }
  geometry::Point at = lines.empty() ? geometry::Point{} : lines.points[0];
  append_in_order(lines, {PathKind::kMeasurement, measure.material, false, 0}, options, at, paths);
}

// Returns true for a layer with the paths of the one that was planned last, but for its number and height.
bool as_before(const LayerRegions& regions, const PathOptions& options, const PathWork& work) {
  const LayerRegions& last = work.last_regions;
  const auto turns = [](const ExtrusionOptions& o) {
    return o.pattern == FillPattern::kLines || o.pattern == FillPattern::kZigzag;
  };
  const bool turned =
      (turns(options.part) || turns(options.scaffold)) && (regions.layer - last.layer) % 2 != 0;
  return work.last_paths.layer != 0 && options == work.last_options && !turned &&
         options.seam != SeamPlacement::kRandom && regions.height == last.height &&
         hooks_in(regions.layer, options.hook) == hooks_in(last.layer, options.hook) &&
         regions.by_material == last.by_material && regions.contours == last.contours &&
         regions.simplified_mm == last.simplified_mm && regions.contours_alone == last.contours_alone;
}

}  // namespace

void check(const PathOptions& o) {
  for (const auto& [prefix, bead] : {std::pair{"part.", &o.part}, {"scaffold.", &o.scaffold}}) {
    check_options("paths", kExtrusionRings, *bead, prefix);
    check_options("paths", OptionTable{kExtrusionFillWidth, kExtrusionGap}, *bead, prefix);
  }
  check_options("paths", OptionTable{kSupportBuffer}, o.support, "support.");
  check_options("paths", kHookOptions, o.hook, "hook.");
  check_options("paths", OptionTable{kMeasureSpacing}, o.measure, "measure.");
  check_options("paths", kMeasurePlace, o.measure, "measure.");
  check_options("paths", kPathOrder, o);
}

LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options, PathWork& work) {
  check(options);
  if (as_before(regions, options, work)) {
    LayerPaths paths = work.last_paths;
    paths.layer = regions.layer;
    paths.z = regions.z;
    return paths;
  }
  ++work.planned;
  LayerPaths paths;
  paths.layer = regions.layer;
  paths.z = regions.z;
  paths.height = regions.height;
  geometry::Point at{units(options.start_x_mm), units(options.start_y_mm)};
  const geometry::Region none;
  const Simplified simplified{&regions.contours, regions.simplified_mm, regions.contours_alone};
  const geometry::Region& part = regions.by_material.empty() ? none : regions.by_material[kPartMaterial];
  const int hooks = hooks_in(regions.layer, options.hook);
  for (std::size_t m = 0; m < regions.by_material.size(); ++m) {
    const geometry::Region& region = regions.by_material[m];
    if (region.empty()) continue;
    if (m == kScaffoldMaterial && hooks > 0) {
      plan_material(room_for_hook(region, part, hooks, options), std::uint8_t(m), options, hooks, at, paths,
                    part, {}, work);
    } else {
      plan_material(region, std::uint8_t(m), options, 0, at, paths, part,
                    m == kScaffoldMaterial ? Simplified{} : simplified, work);
    }
  }
  if (options.measure.on && options.measure.material < regions.by_material.size())
    plan_measurement(regions.by_material[options.measure.material], options, paths);
  work.last_regions = regions;
  work.last_options = options;
  work.last_paths = paths;
  return paths;
}

LayerPaths plan_layer(const LayerRegions& regions, const PathOptions& options) {
  PathWork work;
  return plan_layer(regions, options, work);
}

}  // namespace firn::slice
