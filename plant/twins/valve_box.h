// ValveBox is a valve's microcontroller as the ice world wires it: a serial port, the robot's signal, the
// robot's enable line.
#pragma once

#include "plant/twins/twin.h"

namespace firn::plant {

class ValveBox : public Twin {
 public:
  using Twin::Twin;
  virtual void signal(std::int64_t t_us) = 0;   ///< the robot's line rises
  virtual void disable(std::int64_t t_us) = 0;  ///< its enable line falls: an open valve is closed
};

}  // namespace firn::plant
