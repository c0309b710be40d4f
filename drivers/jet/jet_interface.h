// JetInterface has the orders of a print to a jet, of any kind.
#pragma once

#include <cstdint>

#include "drivers/link/driver.h"

namespace firn::drivers {

class JetInterface : public Driver {
 public:
  /// One droplet a pulse of the trigger input from now on; Result{kReady} when armed.
  virtual void arm(std::int64_t expected, std::int64_t now_us, Effects& fx) = 0;
  /// The same with small droplets. Refused by a kind that has one size.
  virtual void arm_small(std::int64_t expected, std::int64_t now_us, Effects& fx) = 0;
  /// No droplet from now on; Result{kDone} with counted = -1 where the jet does not count, and with until_us
  /// where a stop has disarmed the jet before. Result{kUnknown} if the jet may have been disarmed at any time
  /// since arm(): its droplets are in doubt.
  virtual void disarm(std::int64_t now_us, Effects& fx) = 0;
  /// Droplets at the jet's own rate until disarm() or a stop: Result{kReady} when they come. Refused by a
  /// kind that cannot.
  virtual void jet(std::int64_t now_us, Effects& fx) = 0;

 protected:
  explicit JetInterface(const Dialect& dialect) : Driver(dialect) {}
};

}  // namespace firn::drivers
