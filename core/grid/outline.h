// OutlineStats holds how well a part keeps within its outline: volume beside it and missing in it, errors of
// its size, its edge. They are computed here alone; kOutlineMetrics has their names and units.
#pragma once

#include <array>
#include <string_view>

#include "core/grid/grid.h"

namespace firn {

/// Values that errors inside the part do not show. NaN = cannot be told: no cell beside the part was
/// measured, or the surface does not reach the level.
struct OutlineStats {
  double overspill = kNotMeasured;      ///< volume outside the mask over the target's volume inside it
  double missing = kNotMeasured;        ///< volume below the target inside the mask over the target's there
  double misplaced = kNotMeasured;      ///< the sum of both, which no inset of the outline lowers
  double first_ring_mm = kNotMeasured;  ///< mean height of the cells that share a side with the part
  double size_error_x_mm =
      kNotMeasured;  ///< width along x at half the target's largest height, less the target's
  double size_error_y_mm = kNotMeasured;   ///< the same along y
  double edge_width_mm = kNotMeasured;     ///< core/grid/edge_profile.h
  double corner_radius_mm = kNotMeasured;  ///< likewise
  double rms_mm = kNotMeasured;            ///< of the height about the target over the whole part
  double rms_inside_mm = kNotMeasured;     ///< the same over inside_of()
  bool cut = false;  ///< the surface reaches the level at the border of its map: the part may be wider
};

/// Name, unit, words and meaning of a value, as every table, file and page has it.
struct OutlineMetric {
  std::string_view name, unit;
  std::string_view words;  ///< for a column or a line that people read: "size error x"
  std::string_view meaning;
  double OutlineStats::*value;
  double factor;  ///< from the value's own unit to that of the name
  int decimals;
};

inline constexpr OutlineMetric kOutlineMetrics[] = {
    {"overspill_pct", "%", "overspill", "volume beside the part, of the part's volume",
     &OutlineStats::overspill, 1e2, 2},
    {"missing_pct", "%", "missing inside", "volume missing inside the part, of the part's volume",
     &OutlineStats::missing, 1e2, 2},
    {"misplaced_pct", "%", "misplaced", "volume beside the part and missing inside it, of the part's volume",
     &OutlineStats::misplaced, 1e2, 2},
    {"first_ring_um", "um", "first ring", "mean height of the cells beside the part",
     &OutlineStats::first_ring_mm, 1e3, 1},
    {"size_x_um", "um", "size error x", "error of the part's width along x at half height",
     &OutlineStats::size_error_x_mm, 1e3, 1},
    {"size_y_um", "um", "size error y", "error of the part's width along y at half height",
     &OutlineStats::size_error_y_mm, 1e3, 1},
    {"edge_width_um", "um", "edge width", "width of the part's edge from 10 to 90 % of its height",
     &OutlineStats::edge_width_mm, 1e3, 1},
    {"corner_radius_um", "um", "corner radius", "radius of the outline's convex corners at half height",
     &OutlineStats::corner_radius_mm, 1e3, 1},
    {"part_rms_um", "um", "RMS of the part", "RMS of the surface about the target over the whole part",
     &OutlineStats::rms_mm, 1e3, 3},
    {"inside_rms_um", "um", "RMS inside",
     "RMS of the surface about the target over the cells whose eight neighbours belong to the part",
     &OutlineStats::rms_inside_mm, 1e3, 3},
};

/// Returns the row of a name. @throws std::invalid_argument: there is none
const OutlineMetric& outline_metric(std::string_view name);

/// Computes the values of a surface. Widths are those between a caliper's jaws: from the first to the last
/// crossing of the level over all rows, interpolated linearly between cells. The target counts as 0 outside
/// the mask. `height` may reach beyond the target's grid by whole cells, so that material beyond it counts
/// too. Sums run in index order, so equal input gives equal bytes.
/// @param fine the same surface on cells that are whole parts of those of `height`, over the same ground:
/// edge width and corner radius are of it; nullptr: of `height`
/// @throws std::invalid_argument: a mask of another size, a height map that does not hold the target's
/// cells, a fine one of other ground
OutlineStats outline_stats(const HeightMap& height, const HeightMap& target, const Mask& mask,
                           const HeightMap* fine = nullptr);

/// Returns the box around the cells of a part: x, y and its greatest height [mm].
std::array<double, 3> part_size_mm(const HeightMap& target, const Mask& mask);

/// Returns the cells of a mask whose eight neighbours all belong to it; a cell at the grid's border does not.
Mask inside_of(const Mask& mask);

}  // namespace firn
