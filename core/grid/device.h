// Outcome, DeviceState and Severity hold the vocabulary of instruments that drivers and messages share. The
// numbers are those of answer_t, device_state_t and fault_t.
#pragma once

#include <cstdint>

namespace firn {

/// The end of a command.
enum class Outcome : std::int8_t {
  kReady = 0,    ///< armed
  kDone = 1,     ///< carried out
  kNone = 2,     ///< nothing physical happened
  kUnknown = 3,  ///< [unknown_from, unknown_to) may or may not have happened
  kRefused = 4,  ///< not started; nothing was sent to the instrument
  kFailed = 5,   ///< ended early; `counted` is exactly what happened (a prefix of the firing order)
};

/// State of one instrument and its link.
enum class DeviceState : std::int8_t {
  kDisconnected = 0,
  kConnecting = 1,
  kIdentifying = 2,
  kSafe = 3,  ///< idle, nothing can move or fire
  kStaged = 4,
  kArmed = 5,
  kActive = 6,
  kSuspect = 7,  ///< a reply is missing or damaged: the link is drained and probed before it is used again
  kFault = 8,    ///< latched: only a new connection leaves it
  kEstop = 9,
};

enum class Severity : std::int8_t {
  kNotice = 0,
  kWarning = 1,
  kStop = 2,  ///< the print is stopped safely
};

}  // namespace firn
