// Computes solids to be printed inside a block of support: analytic shapes and stacks of images.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/grid/geometry.h"

namespace firn {

/// Sizes in mm; shapes are centred on the grid. Fields a shape does not use are ignored.
struct SolidSpec {
  std::string kind = "none";       ///< see solid_kinds(); "none": one ink, no geometry
  double outer_diameter_mm = 0.0;  ///< vertical pipe: outside; ellipsoid: along x and y
  double inner_diameter_mm = 0.0;  ///< vertical pipe: bore
  double branch_width_mm = 0.0;    ///< pipe_junction: outside of the lying pipe along y,
  double branch_height_mm = 0.0;   ///< and along z (a flat lab prints an elliptic pipe)
  double branch_bore_width_mm = 0.0;
  double branch_bore_height_mm = 0.0;
  double centre_z_mm = 0.0;  ///< pipe_junction: axis of the lying pipe; ellipsoid: centre
  double height_mm = 0.0;    ///< ellipsoid: along z
};

inline constexpr OptionTable kSolidSpec{
    Option{"outer_diameter_mm", &SolidSpec::outer_diameter_mm, "mm", within(0, 1e4),
           "pipe, pipe_junction: standing pipe; ellipsoid: along x and y"},
    Option{"inner_diameter_mm", &SolidSpec::inner_diameter_mm, "mm", within(0, 1e4),
           "pipe, pipe_junction: bore of the standing pipe"},
    Option{"branch_width_mm", &SolidSpec::branch_width_mm, "mm", within(0, 1e4),
           "pipe_junction: lying pipe, along y"},
    Option{"branch_height_mm", &SolidSpec::branch_height_mm, "mm", within(0, 1000),
           "pipe_junction: lying pipe, along z"},
    Option{"branch_bore_width_mm", &SolidSpec::branch_bore_width_mm, "mm", within(0, 1e4),
           "pipe_junction: bore of the lying pipe, along y"},
    Option{"branch_bore_height_mm", &SolidSpec::branch_bore_height_mm, "mm", within(0, 1000),
           "pipe_junction: bore of the lying pipe, along z"},
    Option{"centre_z_mm", &SolidSpec::centre_z_mm, "mm", within(0, 1000),
           "pipe_junction: axis of the lying pipe; ellipsoid: centre"},
    Option{"height_mm", &SolidSpec::height_mm, "mm", within(0, 1000), "ellipsoid: along z"},
};
/// Height of one layer of an ImageStack.
inline constexpr Range kImagePitch_mm = above(0, 100);

/// none, pipe, pipe_junction, ellipsoid, images, mesh.
const std::vector<std::string>& solid_kinds();

/// @throws std::invalid_argument naming the size that is out of its range
void check(const SolidSpec& spec);

/// pipe: r_in <= r <= r_out, all heights [Lu 2015, IV-B]. pipe_junction: that pipe and a lying one of
/// elliptic section from its axis towards +x, whose bores join [Figs. 13, 14; the paper prints no sizes].
/// ellipsoid: hangs in the support. @throws std::invalid_argument naming the field: an unknown kind, sizes
/// not above 0, a bore not smaller than its pipe; "none", "images" and "mesh", which are no analytic shapes.
std::unique_ptr<Solid> make_solid(const SolidSpec& spec, const GridSpec& grid);

/// Layers of cells, bottom to top: layer n fills [n, n + 1) pitch_z. Nothing beside the grid or above.
class ImageStack final : public Solid {
 public:
  /// @throws std::invalid_argument: no layer, a layer of another size than the grid, pitch not above 0.
  ImageStack(const GridSpec& grid, double pitch_z_mm, std::vector<Mask> layers);
  bool contains(double x_mm, double y_mm, double z_mm) const override;

 private:
  GridSpec grid_;
  double pitch_z_mm_;
  std::vector<Mask> layers_;
};

}  // namespace firn
