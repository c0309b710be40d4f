// IceWires carries hardware lines and notes of the ice lab from a twin to the world.
#pragma once

#include <cstdint>

#include "plant/ice/nature.h"
#include "plant/record/record.h"
#include "plant/twins/heater.h"

namespace firn::plant {

class IceWires : public HeaterWires {
 public:
  virtual IceNature& nature() = 0;
  Heat& heat() override { return nature().heat(); }
  /// The robot's signals: 1 valve_a, 2 valve_b, 4 laser.
  virtual void signals(std::int64_t t_us, int mask) = 0;
  virtual void valves_off(std::int64_t t_us) = 0;  ///< the robot's enable line of both valves falls
  virtual void link_closed(std::int64_t t_us, Port port) = 0;  ///< by the instrument
  virtual void fired(const FiringRecord& firing) = 0;
};

}  // namespace firn::plant
