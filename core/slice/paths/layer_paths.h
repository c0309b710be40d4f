// What the slicer makes of one layer: deposition and measurement paths in printing order, and what they
// cover.
#pragma once

#include <cstdint>
#include <vector>

#include "core/path/path.h"
#include "core/geometry/region.h"

namespace firn::slice {

/// What one line of a layer is. Lengths in units of kMmPerUnit.
struct PathInfo {
  PathKind kind = PathKind::kFill;
  std::uint8_t material = 0;  ///< 0 = part, 1 = scaffold, further ones by job
  bool closed = false;        ///< the last point joins the first, which is not repeated
  std::int32_t width = 0;     ///< deposited width; 0 for measurement
  bool operator==(const PathInfo&) const = default;
};

/// Paths of one layer in printing order. `info[i]` tells what `lines[i]` is.
struct LayerPaths {
  std::int32_t layer = 0;   ///< 1-based
  std::int32_t z = 0;       ///< units, height of the layer's top
  std::int32_t height = 0;  ///< units
  Rings lines;
  std::vector<PathInfo> info;
  std::uint32_t clipper_rings =
      0;  ///< rings taken from Clipper because the wavefront could not answer for them
  bool operator==(const LayerPaths&) const = default;
};

/// Length and volume (width x height x length, overlaps counted twice) of one material's deposition paths in
/// a layer.
struct MaterialUse {
  double length_mm = 0.0;
  double volume_mm3 = 0.0;
};
/// One per material from 0 to the largest that occurs; measurement paths deposit nothing and do not count.
std::vector<MaterialUse> material_use(const LayerPaths&);

/// Travel between the paths, in printing order, beginning at the first path's first point.
double transit_mm(const LayerPaths&);

/// One of the lines in the terms of the rest of the house.
Path to_path(const LayerPaths&, std::size_t line);

}  // namespace firn::slice
