// SimFault holds a fault of an instrument's link or of the instrument itself, which tests inject.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace firn::plant {

enum class FaultKind : std::uint8_t {
  kDropReply,   ///< the next `count` replies are not sent
  kDelayReply,  ///< the next `count` replies come `delay_us` later
  kSplitReply,  ///< the next `count` replies come byte by byte, `delay_us` apart
  kFlipBit,     ///< bit `count` (from the first byte's lowest) of the next reply is inverted
  kHang,        ///< bytes are accepted and nothing happens until kResume
  kResume,      ///< ends kHang
  kClose,       ///< the instrument closes its port
  kReboot,      ///< state lost, boot count + 1, port closed
  kTrip,        ///< the device's own fault: stage ESTOP bit, lamp alarm, JetTwin::trip; docs/plant-ice.md
  kEcho,        ///< the next `count` pieces that the host sends come back as they are
  kStray,       ///< the next `count` replies come after a copy of the reply before them
  kPower,       ///< as kReboot, but a serial port stays open: no cable tells of it
  kHalfOpen,    ///< nothing comes or goes on this connection and nothing ends it; the next one is sound
};

struct SimFault {
  std::string port;
  FaultKind kind = FaultKind::kDropReply;
  std::int64_t count = 1;
  std::int64_t delay_us = 0;
};

/// Returns the kind of this name: "drop", "delay", "split", "flip", "hang", "resume", "close", "reboot",
/// "trip", "echo", "stray", "power", "half_open".
/// @throws std::invalid_argument for another name
FaultKind fault_kind(std::string_view name);
/// Returns the name that fault_kind() takes.
std::string_view fault_name(FaultKind kind);

}  // namespace firn::plant
