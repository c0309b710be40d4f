// Bed holds the surface under the nozzles as a fine height field: table, frozen water, frozen SME, debris. A
// drop becomes a pool before it freezes: liquid of even surface within the pool's radius, so that low ground
// receives more.
//
// Radius: R = V' / (sqrt(3) h). V' is the volume per length of path (from the distance to the valve's last
// drop), h the thickness at which liquid on level ground stops [Barnett 2012, 4.2.1: at most 0.25 mm]. A drop
// alone has pi R^2 h = V. A row of such pools at a spacing of V' / h adds up nearly level: 1.5 mm at 0.36
// mm^2, 3 mm at 0.72 mm^2, the thesis's two widths.
// Inside: dz = k(r) clamp(s - z, 0, deepest), s such that the volume is V; k is 1 up to sqrt(2/3) R and falls
// to 0 at R.
// Edges: ground that lies edge_mm or more under the liquid, there and 1.5 mm further out, is over an edge.
// The share `spill` of the liquid that k alone puts there falls down, the rest hangs on. From a spire
// narrower than the pool all of this liquid slides, and a little more. This is the fall-off at edges without
// scaffold around them.
// Freezing: dz is multiplied by 1 + pattern(x, y) + roughness(x, y, layer).
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "plant/config/ice_config.h"
#include "plant/record/archive.h"

namespace firn::plant {

enum class Ground : std::uint8_t { kTable = 0, kWater = 1, kScaffold = 2, kDebris = 3 };

/// Holds the balance of volumes [mm^3]: landed + grown + debris = on the field + lost, to rounding.
struct IceLedger {
  double landed[2] = {};  ///< left the nozzle, by material
  double lost = 0.0;      ///< fell beside the field
  double grown = 0.0;     ///< by freezing, either sign
  double debris = 0.0;
};

class Bed {
 public:
  Bed(const IceWorldConfig& config, std::uint64_t seed);

  struct Drop {
    double x_mm = 0.0, y_mm = 0.0, volume_mm3 = 0.0;
    double per_length_mm2 = 0.0;  ///< V'; 0: alone
    int material = 0;             ///< 0 water, 1 SME
  };
  /// @returns false when the drop fell beside the field
  bool land(const Drop& drop);
  /// Draws of the roughness are keyed by the nozzle's height, the same for every run of a seed.
  void set_nozzle_height(double z_mm);
  void add_debris(double x_mm, double y_mm, double height_mm, double radius_mm);

  /// Returns the surface height [mm], bilinear between centres; beside the field that of the bare table.
  double height_mm(double x_mm, double y_mm) const;
  Ground ground(double x_mm, double y_mm) const;
  double slope(double x_mm, double y_mm) const;  ///< |grad z|
  double highest_mm() const { return highest_mm_; }
  double table_mm(double x_mm, double y_mm) const;

  /// Returns the mean over each cell of `grid` [mm above z = 0]; NaN where a cell is not wholly on the field.
  HeightMap mean_over(const GridSpec& grid) const;
  /// Returns the same for one material's thickness [mm].
  HeightMap thickness_over(const GridSpec& grid, int material) const;
  double volume_mm3() const;  ///< above the table
  const IceLedger& ledger() const { return ledger_; }

  int width() const { return nx_; }
  int height() const { return ny_; }
  double cell_mm() const { return cell_; }
  double centre_x_mm(int i) const { return x0_ + (i + 0.5) * cell_; }
  double centre_y_mm(int j) const { return y0_ + (j + 0.5) * cell_; }
  double z_mm(int i, int j) const { return z_[std::size_t(j) * std::size_t(nx_) + std::size_t(i)]; }
  void io(Archive& a);

 private:
  bool inside(double x_mm, double y_mm) const;
  void renew_gain();
  bool open_beyond(const Drop& drop, double dx, double dy, double below_mm) const;
  HeightMap mean_of(const std::vector<double>& values, const GridSpec& grid) const;

  IceWorldConfig config_;
  std::uint64_t seed_;
  double cell_, x0_, y0_;
  int nx_, ny_;
  std::vector<double> z_, table_, water_;
  std::vector<float> gain_, pattern_;
  std::vector<std::uint8_t> top_;
  std::int32_t layer_ = 0;
  double highest_mm_ = -1e9;
  IceLedger ledger_;
};

}  // namespace firn::plant
