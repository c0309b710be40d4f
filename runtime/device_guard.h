// DeviceGuard holds the lease of a driver: the driver may be armed or active only within lease_s of the last
// ENABLE of the current epoch; commands carry the epoch and an older one is refused. Pure; every driver node
// holds one.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/time.h"

namespace firn {

class DeviceGuard {
 public:
  /// An ENABLE arrived. Epochs never go back. The lease counts from the sender's stamp `sent`: a queue that
  /// delays the message does not extend it. A stamp of the future counts as `now`.
  void enable(std::int64_t epoch, bool enabled, double lease_s, Time sent, Time now);
  /// A SAFE_STOP arrived. @returns true if it raises the epoch, i.e. the device must be made safe now.
  bool safe_stop(std::int64_t epoch);
  /// A local stop (lost lease, closed control pipe): nothing is allowed until an ENABLE of a newer epoch.
  void local_stop();

  bool allowed(Time now) const { return enabled_ && now <= lease_until_; }
  /// Why a command of `epoch` must be refused at `now`; empty = it may run.
  std::string command_refusal(std::int64_t epoch, Time now) const;
  /// Why nothing of a command that was allowed before may leave at `now`; empty = it may.
  /// @param stop_epoch of a SAFE_STOP that waits to be handled; 0 = none waits
  std::string lease_refusal(Time now, std::int64_t stop_epoch) const;

  std::int64_t epoch() const { return epoch_; }
  Time lease_until() const { return lease_until_; }

 private:
  std::int64_t epoch_ = 0;
  std::int64_t stopped_epoch_ = -1;  ///< enables of this epoch or older are void
  bool enabled_ = false;
  Time lease_until_;
};

}  // namespace firn
