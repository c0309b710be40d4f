// Field holds the surface as a fine height field: cured ink under liquid ink. Droplets land at continuous
// positions, liquid flows downhill among fine cells until the lamp cures it, volume is conserved.
#pragma once

#include <cstdint>
#include <vector>

#include "core/grid/grid.h"
#include "plant/config/world_config.h"
#include "plant/record/archive.h"

namespace firn::plant {

/// Holds the balance of volumes [mm^3]: landed = on the field + lost + shrunk, to rounding.
struct VolumeLedger {
  double landed = 0.0;  ///< volume of all droplets and satellites that left the nozzle
  double lost = 0.0;    ///< fell beside the field
  double shrunk = 0.0;  ///< removed by curing
};

/// Fine cells of size pitch / fine_cells over the grid and a margin. Fine cell (a, b) has its centre at
/// (left_mm + (a + 0.5) dx_mm, bottom_mm + (b + 0.5) dy_mm); index b * width + a.
class Field {
 public:
  Field(const GridSpec& grid, int fine_cells, int margin_cells);

  /// Adds `volume_mm3` of liquid about (x_mm, y_mm): cap plus film, low ground preferred, then
  /// `levelling_steps` steps in which each pair of neighbouring fine cells of the footprint exchanges
  /// levelling x (difference of surface height), at most run_share of the liquid of the giving cell. A
  /// footprint not wholly on the field is lost.
  /// @returns false when lost
  bool land(const DropletParams& p, double volume_mm3, double x_mm, double y_mm);

  /// Turns all liquid into solid and removes the share `shrink` of its volume.
  void cure(double shrink);

  /// Returns the mean surface height over each cell of the grid [mm].
  HeightMap cell_means() const { return means_over(0); }
  /// Returns the same over the grid and the cells of the margin around it.
  HeightMap means_with_margin() const { return means_over(margin_); }
  /// Returns the height of every fine cell, margin included [mm].
  HeightMap fine_surface() const;
  double volume_mm3() const;
  const VolumeLedger& ledger() const { return ledger_; }
  VolumeLedger& ledger() { return ledger_; }

  double surface_mm(std::size_t n) const { return solid_[n] + liquid_[n]; }
  void set_solid_mm(int a, int b, double z_mm) { solid_[std::size_t(b) * width_ + a] = z_mm; }
  int width() const { return width_; }
  int height() const { return height_; }
  int fine_cells() const { return fine_; }
  int margin_cells() const { return margin_; }
  double left_mm() const { return left_mm_; }
  double bottom_mm() const { return bottom_mm_; }
  double dx_mm() const { return dx_mm_; }
  double dy_mm() const { return dy_mm_; }
  void io(Archive& a) { a.all(solid_, liquid_, ledger_); }

 private:
  HeightMap means_over(int margin) const;
  GridSpec grid_;
  int fine_, margin_, width_, height_;
  double dx_mm_, dy_mm_, left_mm_, bottom_mm_;
  std::vector<double> solid_, liquid_;
  VolumeLedger ledger_;
};

}  // namespace firn::plant
