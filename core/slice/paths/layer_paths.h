// LayerPaths holds the deposition and measurement paths of one layer in printing order.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/region.h"
#include "core/path/path.h"

namespace firn::slice {

/// The properties of one line of a layer. Lengths in units of kMmPerUnit.
struct PathInfo {
  PathKind kind = PathKind::kFill;
  std::uint8_t material = 0;  ///< 0 = part, 1 = scaffold, further ones by job
  bool closed = false;        ///< the last point joins the first, which is not repeated
  std::int32_t width = 0;     ///< deposited width; 0 for measurement
  bool operator==(const PathInfo&) const = default;
};

/// Paths of one layer in printing order; `info[i]` describes `lines[i]`.
struct LayerPaths {
  std::int32_t layer = 0;   ///< 1-based
  std::int32_t z = 0;       ///< units, height of the layer's top
  std::int32_t height = 0;  ///< units
  geometry::Rings lines;
  std::vector<PathInfo> info;
  std::uint32_t clipper_rings = 0;  ///< rings computed by Clipper because the wavefront was ambiguous
  bool operator==(const LayerPaths&) const = default;
};

/// Length and volume (width x height x length, overlaps counted twice) of one material's deposition paths in
/// a layer.
struct MaterialUse {
  double length_mm = 0.0;
  double volume_mm3 = 0.0;
};
/// Returns one entry per material from 0 to the maximum that occurs; measurement paths do not count.
std::vector<MaterialUse> material_use(const LayerPaths&);

/// Returns the travel between the paths, in printing order, from the first point of the first path.
double transit_mm(const LayerPaths&);

/// Returns one of the lines as a core path.
Path to_path(const LayerPaths&, std::size_t line);

}  // namespace firn::slice
