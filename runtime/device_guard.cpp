#include "runtime/device_guard.h"

#include <algorithm>

namespace firn {

void DeviceGuard::enable(std::int64_t epoch, bool enabled, double lease_s, Time sent, Time now) {
  if (epoch < epoch_ || epoch <= stopped_epoch_) return;
  epoch_ = epoch;
  enabled_ = enabled;
  lease_until_ = std::min(sent, now).after_s(lease_s);
}

bool DeviceGuard::safe_stop(std::int64_t epoch) {
  // SAFE_STOP carries the raised epoch: everything commanded under an older one is void.
  if (epoch <= epoch_) return false;
  epoch_ = epoch;
  enabled_ = false;
  return true;
}

void DeviceGuard::local_stop() {
  stopped_epoch_ = epoch_;
  enabled_ = false;
}

std::string DeviceGuard::command_refusal(std::int64_t epoch, Time now) const {
  if (epoch < epoch_)
    return "enable epoch " + std::to_string(epoch) + " is older than " + std::to_string(epoch_);
  if (epoch > epoch_)
    return "enable epoch " + std::to_string(epoch) + " is not known yet (now " + std::to_string(epoch_) + ")";
  return lease_refusal(now, 0);
}

std::string DeviceGuard::lease_refusal(Time now, std::int64_t stop_epoch) const {
  if (stop_epoch > epoch_) return "a SAFE_STOP of epoch " + std::to_string(stop_epoch) + " waits";
  if (!enabled_) return "not enabled by safety in epoch " + std::to_string(epoch_);
  if (now > lease_until_)
    return "the lease of epoch " + std::to_string(epoch_) + " ended " +
           std::to_string(seconds_between(lease_until_, now)) + " s ago";
  return {};
}

}  // namespace firn
