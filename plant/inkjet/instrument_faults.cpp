#include "plant/inkjet/instrument_faults.h"

#include <numbers>

#include "core/exact/exact_math.h"

namespace firn::plant {

TruePlace true_place(const StageFaults& f, const GridSpec& grid, TruePlace said, double vx_mm_s) {
  if (!f.any()) return said;
  const double turn = 2.0 * std::numbers::pi * said.x_mm / f.cyclic_period_mm;
  const double direction = vx_mm_s > 0.0 ? 1.0 : vx_mm_s < 0.0 ? -1.0 : 0.0;
  return {said.x_mm + f.stretch_x * (said.x_mm - grid.origin_x_mm) + f.cyclic_mm * exact::sin(turn) -
              0.5 * f.backlash_mm * direction,
          said.y_mm + f.stretch_y * (said.y_mm - grid.origin_y_mm)};
}

NozzleShot NozzleFault::fire(std::int64_t t_us, int layer, int droplets) {
  const auto rested = [&](double idle_s) {
    return idle_s > 0.0 && (!fired_ || double(t_us - last_us_) > 1e6 * idle_s);
  };
  if (rested(faults_.weak_idle_s)) weak_left_ = faults_.weak_droplets;
  const bool drips = rested(faults_.drip_idle_s);
  fired_ = true;
  last_us_ = t_us;

  NozzleShot shot{droplets};
  if (layer >= faults_.deflect_layer) {
    shot.dx_mm = faults_.deflect_x_mm;
    shot.dy_mm = faults_.deflect_y_mm;
  }
  if (drips) ++shot.droplets;
  const int missing = weak_left_ < shot.droplets ? weak_left_ : shot.droplets;
  shot.droplets -= missing;
  weak_left_ -= missing;
  if (faults_.dead_layer > 0 && layer >= faults_.dead_layer) shot.droplets = 0;
  return shot;
}

}  // namespace firn::plant
