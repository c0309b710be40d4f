// DropletSource draws the droplets of the natures that share the disturbances of `droplets`: volume, misses
// and drift.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/grid/random.h"
#include "plant/inkjet/model.h"
#include "plant/inkjet/nozzle.h"

namespace firn::plant {

/// Draws have the keys that they have in `droplets`: the n-th droplet of a layer on a cell has one fate in
/// all these natures.
class DropletSource {
 public:
  explicit DropletSource(const WorldConfig& c)
      : grid_(c.grid),
        droplet_(c.droplet),
        seed_(c.seed),
        nozzle_(c.nozzle, c.seed),
        attempts_(c.grid.size(), 0) {}

  /// Returns the droplet of a trigger. @param scattered it lands beside its place, by
  /// droplet.placement_scatter_mm
  Landing fire(const Shot& shot, std::uint32_t layer, bool scattered) {
    Landing out{false, 0.0, shot.x_mm + shot.vx_mm_s * droplet_.flight_time_s,
                shot.y_mm + shot.vy_mm_s * droplet_.flight_time_s};
    const NearestCell cell = nearest_cell(grid_, out.x_mm, out.y_mm);
    const std::uint32_t attempt =
        grid_.contains(cell.i, cell.j) ? attempts_[grid_.index(cell.i, cell.j)]++ : off_grid_attempts_++;
    const auto draw = [&](Purpose purpose, std::uint32_t n) {
      return DrawKey{seed_, purpose, layer, 4 * attempt + n, cell_key(cell)};
    };
    const double factor = nozzle_.fire(shot.t_us);
    out.missed = droplet_.missed_probability > 0.0 &&
                 random_uniform(draw(Purpose::kMissedDroplet, 0)) < droplet_.missed_probability;
    if (out.missed) return out;
    if (scattered && droplet_.placement_scatter_mm > 0.0) {
      out.x_mm += droplet_.placement_scatter_mm * random_normal(draw(Purpose::kDropletPlacement, 0));
      out.y_mm += droplet_.placement_scatter_mm * random_normal(draw(Purpose::kDropletPlacement, 1));
    }
    double scatter = 0.0;
    if (droplet_.size_scatter > 0.0)
      scatter = std::clamp(random_normal(draw(Purpose::kDropletSize, 0)), -4.0, 4.0) * droplet_.size_scatter;
    out.volume_mm3 =
        droplet_.volume_mm3 * droplet_.flow * shot.volume_share * std::max(0.05, factor + scatter);
    return out;
  }
  /// The layer is exposed for the first time. @param layer from 1
  void cured(std::int64_t now_us, std::uint32_t layer) { nozzle_.cured(now_us, layer); }
  /// A new layer begins.
  void measured() {
    std::fill(attempts_.begin(), attempts_.end(), 0u);
    off_grid_attempts_ = 0;
  }
  void io(Archive& a) { a.all(nozzle_, attempts_, off_grid_attempts_); }

 private:
  GridSpec grid_;
  DropletParams droplet_;
  std::uint64_t seed_;
  Nozzle nozzle_;
  std::vector<std::uint32_t> attempts_;  ///< droplets per cell of this layer
  std::uint32_t off_grid_attempts_ = 0;
};

}  // namespace firn::plant
