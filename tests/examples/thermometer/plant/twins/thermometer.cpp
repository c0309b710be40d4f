#include "plant/twins/thermometer.h"

#include <cstdio>

namespace firn::plant {

void ThermometerTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    if (char(b) != '\n') {
      if (line_.size() < 16) line_.push_back(char(b));
      continue;
    }
    if (line_ == "T?") {
      Heat& heat = wires_.nature().heat();
      heat.advance(now_us);
      char text[32];
      std::snprintf(text, sizeof text, "%.2f\n", heat.shown_degC(0));
      link_.reply(open_ ? "OPEN\n" : text, now_us);
    }
    line_.clear();
  }
}

void ThermometerTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  line_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

}  // namespace firn::plant
