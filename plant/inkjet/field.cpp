#include "plant/inkjet/field.h"

#include <algorithm>

#include "plant/inkjet/footprint.h"

namespace firn::plant {

Field::Field(const GridSpec& grid, int fine_cells, int margin_cells)
    : grid_(grid),
      fine_(fine_cells),
      margin_(margin_cells),
      width_((grid.nx + 2 * margin_cells) * fine_cells),
      height_((grid.ny + 2 * margin_cells) * fine_cells),
      dx_mm_(grid.pitch_x_mm / fine_cells),
      dy_mm_(grid.pitch_y_mm / fine_cells),
      left_mm_(grid.origin_x_mm - (0.5 + margin_cells) * grid.pitch_x_mm),
      bottom_mm_(grid.origin_y_mm - (0.5 + margin_cells) * grid.pitch_y_mm),
      solid_(std::size_t(width_) * height_, 0.0),
      liquid_(solid_.size(), 0.0) {}

bool Field::land(const DropletParams& p, double volume_mm3, double x_mm, double y_mm) {
  ledger_.landed += volume_mm3;
  const double u = (x_mm - left_mm_) / dx_mm_, v = (y_mm - bottom_mm_) / dy_mm_;  // in fine cells
  const double reach_mm = std::max(p.cap_radius_mm, p.film_radius_mm);
  const double reach_x = reach_mm / dx_mm_, reach_y = reach_mm / dy_mm_;
  const bool inside = u >= reach_x + 1 && v >= reach_y + 1 && u + reach_x + 1 <= width_ &&
                      v + reach_y + 1 <= height_;  // false for NaN as well
  if (!inside) {
    ledger_.lost += volume_mm3;
    return false;
  }
  // The window reaches one fine cell beyond the footprint, so that levelling can enlarge it.
  const int a0 = int(u - reach_x - 0.5), b0 = int(v - reach_y - 0.5);
  const int nx = std::min(int(u + reach_x + 1.5) - a0, kMaxFootprint),
            ny = std::min(int(v + reach_y + 1.5) - b0, kMaxFootprint);
  const std::size_t corner = std::size_t(b0) * width_ + a0;
  footprint()({solid_.data() + corner, liquid_.data() + corner, width_, nx, ny}, p,
              volume_mm3 / (dx_mm_ * dy_mm_), u - a0, v - b0, dx_mm_, dy_mm_);
  return true;
}

void Field::cure(double shrink) {
  double liquid = 0.0;
  for (std::size_t n = 0; n < liquid_.size(); ++n) {
    liquid += liquid_[n];
    solid_[n] += liquid_[n] * (1.0 - shrink);
    liquid_[n] = 0.0;
  }
  ledger_.shrunk += liquid * shrink * dx_mm_ * dy_mm_;
}

HeightMap Field::means_over(int margin) const {
  GridSpec grid = grid_;
  grid.nx += 2 * margin;
  grid.ny += 2 * margin;
  grid.origin_x_mm -= margin * grid.pitch_x_mm;
  grid.origin_y_mm -= margin * grid.pitch_y_mm;
  const int cut = margin_ - margin;  // cells of the field's own margin left out
  HeightMap means(grid, 0.0);
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      double sum = 0.0;
      for (int b = 0; b < fine_; ++b)
        for (int a = 0; a < fine_; ++a)
          sum += surface_mm(std::size_t((j + cut) * fine_ + b) * width_ + (i + cut) * fine_ + a);
      means.at(i, j) = sum / (fine_ * fine_);
    }
  return means;
}

HeightMap Field::fine_surface() const {
  HeightMap fine({width_, height_, dx_mm_, dy_mm_, left_mm_ + 0.5 * dx_mm_, bottom_mm_ + 0.5 * dy_mm_});
  for (std::size_t n = 0; n < fine.size(); ++n) fine.cells[n] = surface_mm(n);
  return fine;
}

double Field::volume_mm3() const {
  double sum = 0.0;
  for (std::size_t n = 0; n < solid_.size(); ++n) sum += surface_mm(n);
  return sum * dx_mm_ * dy_mm_;
}

}  // namespace firn::plant
