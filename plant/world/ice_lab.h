// The ice lab behind World: its own truth, for tests, reports and SIM_TRUTH. No node knows any of it.
#pragma once

#include <array>
#include <cstdint>

#include "plant/ice/nature.h"

namespace firn::plant {

struct IceTruth {
  std::uint32_t firings = 0;             ///< lists that are over
  std::array<std::int64_t, 2> pulses{};  ///< by valve
  std::array<std::int64_t, 2> last_pulse_us{-1, -1};
  std::int64_t dead_pulses = 0;  ///< that gave nothing
  Collisions collisions;
  IceLedger ledger;
  HeatState heat;
  ArmPose pose;
};

class IceLab {
 public:
  virtual ~IceLab() = default;
  virtual const IceNature& nature() const = 0;
  virtual IceTruth ice_truth() const = 0;
  /// No truth, an instrument: what the balance shows for the cup of what fell beside the field, all of it of
  /// one material.
  /// @param weighing number of this weighing, which keys its error
  virtual double weighed_mg(int material, std::uint32_t weighing) const = 0;
  /// Noise-free mean height over each cell [mm above the part frame's z = 0]; NaN off the simulated surface.
  HeightMap height_over(const GridSpec& grid) const { return nature().bed().mean_over(grid); }
  /// Thickness of one material in each cell [mm]: 0 ice, 1 scaffold.
  HeightMap thickness_over(const GridSpec& grid, int material) const {
    return nature().bed().thickness_over(grid, material);
  }
};

}  // namespace firn::plant
