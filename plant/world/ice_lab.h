// IceLab returns the ice lab's own truth behind World, for tests, reports and SIM_TRUTH. No node knows any of
// it.
#pragma once

#include <array>
#include <cstdint>

#include "plant/ice/nature.h"

namespace firn::plant {

class VplusRobotTwin;

struct IceTruth {
  std::uint32_t firings = 0;             ///< lists that are over
  std::array<std::int64_t, 2> pulses{};  ///< by valve
  std::array<std::int64_t, 2> last_pulse_us{-1, -1};
  std::int64_t dead_pulses = 0;  ///< without a drop
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
  virtual const VplusRobotTwin* vplus_robot() const = 0;  ///< null: the robot's twin runs no V+ text
  /// Returns the balance's reading for its cup, an instrument's value and no truth: the material that fell
  /// beside the field, all of it of one kind.
  /// @param weighing number of this weighing, which keys its error
  virtual double weighed_mg(int material, std::uint32_t weighing) const = 0;
  /// Returns the noise-free mean height over each cell [mm above the part frame's z = 0]; NaN off the
  /// simulated surface.
  HeightMap height_over(const GridSpec& grid) const { return nature().bed().mean_over(grid); }
  /// Returns the thickness of one material in each cell [mm]: 0 ice, 1 scaffold.
  HeightMap thickness_over(const GridSpec& grid, int material) const {
    return nature().bed().thickness_over(grid, material);
  }
};

}  // namespace firn::plant
