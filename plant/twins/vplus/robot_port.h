// RobotPort is the arm, its power and its digital signals as a V+ program commands them.
#pragma once

#include <span>

#include "plant/twins/vplus/value.h"

namespace firn::plant::vplus {

struct Motion {
  PrecisionPoint to{};
  double duration_s = 0.0;  ///< the least time [V+: DURATION is a minimum]; 0: by speed alone
  double percent = 100.0;   ///< of full speed, program's times monitor's
};

class RobotPort {
 public:
  virtual ~RobotPort() = default;
  virtual void signals(std::span<const int> numbers) = 0;  ///< all at once; a negative number is off
  virtual void power(bool on) = 0;
  virtual bool powered() const = 0;
  virtual int calibrate() = 0;  ///< begins. @returns 0 or an error of V+
  virtual bool calibrating() const = 0;
  virtual int state(int number) const = 0;  ///< V+ STATE(number)
  virtual PrecisionPoint here() const = 0;
  virtual PrecisionPoint destination() const = 0;  ///< V+ #PDEST: where it was sent last, or was stopped
  /// Hands over the next motion: it begins now, or when the one before has ended, see waiting().
  /// @returns 0 or an error of V+
  virtual int give(const Motion& motion) = 0;
  virtual bool waiting() const = 0;  ///< a motion that was given has not begun
  virtual bool moving() const = 0;
  virtual void brake() = 0;  ///< ends the motion that has begun; one that waits begins afterwards
};

}  // namespace firn::plant::vplus
