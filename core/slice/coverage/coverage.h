// What the beads of a layer cover, held against what they are to cover.
#pragma once

#include "core/slice/paths/layer_paths.h"
#include "core/slice/paths/path_options.h"
#include "core/slice/paths/path_plan.h"

namespace firn::slice {

/// Areas of one material in one layer. `wanted` is the region offset by first_offset - boundary_width / 2:
/// what the outermost bead is meant to bound, since the material spreads (SME) or shrinks (ice) by the rest
/// [3.7].
struct Coverage {
  double wanted_mm2 = 0.0;
  double swept_mm2 = 0.0;      ///< union of the beads
  double gap_mm2 = 0.0;        ///< wanted, not swept
  double beyond_mm2 = 0.0;     ///< swept, not wanted
  double overlap_mm2 = 0.0;    ///< swept twice or more, each further time counted
  double widest_gap_mm = 0.0;  ///< diameter of the largest circle in a gap, on a grid of pitch_mm
  double pitch_mm = 0.0;       ///< between the scan lines: as asked, or wider where beads have many metres
};

/// Scan lines `pitch_mm` apart, exact along each: an area's error is at most pitch_mm / 2 per mm of edge, and
/// in practice near pitch_mm^1.5 times the root of the edge's length. Where lines of that pitch would cut
/// beads more than 8 million times (some square metres of them), the pitch is as much wider as keeps to that:
/// areas lose little by it, widest_gap_mm is no finer than the pitch. The hook wall counts as scaffold.
/// @return one per material in `regions`
std::vector<Coverage> coverage(const LayerRegions& regions, const LayerPaths& paths,
                               const PathOptions& options, double pitch_mm = 0.1);

}  // namespace firn::slice
