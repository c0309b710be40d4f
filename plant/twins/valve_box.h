// ValveBox is a valve's microcontroller as the ice world wires it: a serial port, the robot's signal, the
// robot's enable line.
#pragma once

#include "plant/twins/ice_wires.h"
#include "plant/twins/twin.h"

namespace firn::plant {

class ValveBox : public Twin {
 public:
  using Twin::Twin;
  virtual void signal(std::int64_t t_us) = 0;   ///< the robot's line rises
  virtual void disable(std::int64_t t_us) = 0;  ///< its enable line falls: an open valve is closed
};

/// The faults of a valve's line and tank, whoever commands the valve: codes of trip().
inline void trip_line(IceNature& nature, int valve, std::int64_t code) {
  constexpr double kFull_mm3 = 2.0e6;
  nature.line(valve).block(code == 2);
  nature.break_valve(valve, code == 3);
  nature.jam_valve(valve, code == 6);
  if (code == 1) nature.heat().empty_tank(valve);
  if (code == 0) nature.heat().fill_tank(valve, kFull_mm3);
  nature.refresh();
}

}  // namespace firn::plant
