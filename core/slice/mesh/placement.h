// Placement holds the transformation of a part to the platform [Barnett, Table 3-1 and 3.1.2]; place()
// computes its integer form.
#pragma once

#include <array>
#include <cstdint>

#include "core/grid/parallel.h"
#include "core/slice/mesh/facets.h"
#include "core/slice/mesh/mesh.h"

namespace firn::slice {

/// Translation of the transformed part along one axis [Table 3-1, note b].
struct AxisPlace {
  enum class Mode {
    kAsIs,      ///< no translation
    kNumber,    ///< the minimum coordinate of the part becomes value_mm
    kCentre,    ///< "cent": the middle of the part becomes 0
    kOriginal,  ///< "orig": the middle of the part keeps its position in the file
  };
  Mode mode = Mode::kAsIs;
  double value_mm = 0.0;
};

/// Scale, then rotations about the axes of a space-fixed frame, one at a time in `order`, then translation.
/// If scale or rotation is not the identity, the part is first moved so that its minimum coordinates are 0
/// [3.1.2].
struct Placement {
  double unit_mm = 1.0;  ///< one unit of the file
  std::array<double, 3> scale = {1.0, 1.0,
                                 1.0};  ///< not 0; a negative product mirrors (facets are turned then)
  std::array<double, 3> rotation_deg = {0.0, 0.0, 0.0};
  std::array<int, 3> order = {0, 1, 2};  ///< a permutation: axis that turns first, second, third
  std::array<AxisPlace, 3> translation;
};

/// Maximum coordinate on the grid, either way (107 m): orientations are then exact in 64 bits.
inline constexpr std::int32_t kMaxUnits = (1 << 30) - 1;

/// The placement of one part: grid point = round(matrix * p + shift).
struct Affine {
  std::array<double, 9> matrix{};  ///< rows; units of the grid per unit of the file
  std::array<double, 3> shift{};   ///< units of the grid
  bool mirrors = false;            ///< corners must be taken in reverse
  Vertex low, high;                ///< box of the placed part; low > high when no facet is finite
  std::size_t not_finite = 0;      ///< facets with a corner that is not a number; left out everywhere
  double coarse_mm = 0.0;          ///< distance of neighbouring floats at the part's largest coordinate
};

/// Computes the bounding box of the part (one pass over the facets, two if it is rotated) and its placement.
/// @throws std::invalid_argument naming the field: unit or scale 0 or not finite, order not a permutation; a
/// part that would exceed kMaxUnits.
Affine place(const FacetView& facets, const Placement& placement, const ParallelFor& parallel);

/// Returns the part as an indexed mesh: corners on the same grid point become one vertex (linear time, by
/// hash), facets that are not finite or lose a corner are left out; vertices are in the order of their first
/// use.
Mesh weld(const FacetView& facets, const Affine& affine);

}  // namespace firn::slice
