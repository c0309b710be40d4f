// Event holds one input of a node, Output one request of a node: plain data, so that a write-ahead file, the
// in-process Lab and replay handle them alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "runtime/time.h"

namespace firn {

enum class EventKind : std::uint8_t { kStart = 1, kMessage, kWake, kIo, kLink, kLocalStop, kRefused };

struct Event {
  EventKind kind = EventKind::kStart;
  Time now;
  std::int32_t incarnation = 0;         ///< kStart: 0 at first, +1 at each resume
  std::string_view channel;             ///< kMessage
  std::uint32_t id = 0;                 ///< kWake: TimerId; kIo, kLink, kRefused: PortId
  Time due;                             ///< kWake: when it was armed for
  LinkState link = LinkState::kClosed;  ///< kLink
  std::span<const std::byte> bytes;     ///< kMessage: encoded message; kIo: bytes of the instrument;
                                        ///< kLocalStop, kRefused: the cause
};

enum class OutputKind : std::uint8_t { kSend = 1, kWrite, kArm, kCancel, kReopen, kFinish };

struct Output {
  OutputKind kind = OutputKind::kSend;
  std::string_view channel;  ///< kSend
  std::uint32_t id = 0;      ///< kWrite, kReopen: PortId; kArm, kCancel: TimerId; kFinish: exit status
  Time at;                   ///< kArm
  std::span<const std::byte> bytes;  ///< kSend: encoded message; kWrite: for the instrument; kFinish: reason
};

}  // namespace firn
