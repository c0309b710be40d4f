// coverage() computes the areas that the extrusion lines of a layer cover, exceed or leave uncovered.
#pragma once

#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_options.h"
#include "core/slice/paths/path_plan.h"

namespace firn::slice {

/// Areas of one material in one layer. `wanted` is the region offset by first_offset - boundary_width / 2:
/// the area that the outermost line is meant to bound, since the material spreads (SME) or shrinks (ice) by
/// the rest [3.7].
struct Coverage {
  double wanted_mm2 = 0.0;
  double swept_mm2 = 0.0;      ///< union of the extrusion lines
  double gap_mm2 = 0.0;        ///< wanted but not swept
  double beyond_mm2 = 0.0;     ///< swept but not wanted
  double overlap_mm2 = 0.0;    ///< swept more than once, each further time counted
  double widest_gap_mm = 0.0;  ///< diameter of the largest circle in a gap, on a grid of pitch_mm
  double pitch_mm = 0.0;       ///< of the scan lines: as requested, or larger for very long paths
};

/// Integrates along scan lines `pitch_mm` apart, exactly along each: the error of an area is at most pitch_mm
/// / 2 per mm of edge, and in practice near pitch_mm^1.5 times the root of the edge length. Where the scan
/// lines would intersect extrusion lines more than 8 million times (some square metres of them), the pitch is
/// increased to meet that limit: areas lose little accuracy, widest_gap_mm is no finer than the pitch. The
/// hook wall counts as scaffold.
/// @return one per material in `regions`
std::vector<Coverage> coverage(const LayerRegions& regions, const LayerPaths& paths,
                               const PathOptions& options, double pitch_mm = 0.1);

}  // namespace firn::slice
