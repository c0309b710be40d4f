// DriverEvent holds one report of a driver to its node, Effects the outcome of one step of a driver.
#pragma once

#include <any>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "core/grid/device.h"
#include "core/grid/figure.h"

namespace firn::drivers {

const char* name(DeviceState state);
/// Returns the state as a sentence about an instrument says it: (the jet is) "armed", "not identified yet".
const char* standing(DeviceState state);
const char* name(Outcome outcome);

/// Interlock numbers of docs/safety.md that drivers raise.
enum Code : std::int32_t {
  kNoCode = 0,
  kEstop = 1,
  kLinkLost = 2,
  kValveLost = 3,
  kStall = 5,
  kTimeSlip = 7,
  kUnreachable = 8,
  kLampOn = 9,
  kTemperature = 10,
  kJetLimit = 11,
  kLimit = 14,
  kCommandRejected = 100,
  kAxisFault = 101,
  kPulseCount = 102,
  kInstrument = 103
};

struct StateChange {
  DeviceState state = DeviceState::kDisconnected;
  std::string text;
};

/// The end of the command in progress; exactly one per accepted command.
struct Result {
  Outcome outcome = Outcome::kDone;
  std::int64_t counted =
      -1;  ///< droplets, rows … known to have been triggered; -1 = the instrument does not count
  std::int64_t expected = 0;
  std::int64_t unknown_from = 0;
  std::int64_t unknown_to = 0;
  std::int32_t code = kNoCode;
  std::string text;
  Figure figure = {};         ///< of the text
  std::int64_t until_us = 0;  ///< answer_t.until_utime_us
};

struct Progress {
  std::int32_t rows_done = 0;
  std::int32_t rows = 0;
  std::int64_t counted = 0;
};

struct Fault {
  Severity severity = Severity::kWarning;
  std::int32_t code = kNoCode;
  std::string text;
  Figure figure = {};  ///< of the text
};

/// One measurement of the instrument, of a type that its driver lists (MeasurementOf).
struct Measured {
  std::any value;
};

using DriverEvent = std::variant<StateChange, Result, Progress, Fault, Measured>;

template <class T>
concept CommonEvent = std::is_same_v<T, StateChange> || std::is_same_v<T, Result> ||
    std::is_same_v<T, Progress> || std::is_same_v<T, Fault>;

/// @tparam T a common event or the type of a measurement
/// @returns the event as a T; null if it is another one
template <class T>
const T* event_cast(const DriverEvent& event) {
  if constexpr (CommonEvent<T>) {
    return std::get_if<T>(&event);
  } else {
    const Measured* measured = std::get_if<Measured>(&event);
    return measured ? std::any_cast<T>(&measured->value) : nullptr;
  }
}

namespace detail {
template <class T, class List>
inline constexpr bool kListed = false;
template <class T, class... Listed>
inline constexpr bool kListed<T, std::tuple<Listed...>> = (std::is_same_v<T, Listed> || ...);
}  // namespace detail

/// T is one of the types that `Of` measures. A driver lists them: `using Measurements = std::tuple<Samples>`.
/// Its node takes every one of them (runtime/driver_node.h).
template <class T, class Of>
concept MeasurementOf = detail::kListed<T, typename Of::Measurements>;

/// Filled by every call of a driver; the caller clears it and hands it in again, so that a steady state
/// allocates nothing.
struct Effects {
  std::vector<std::byte> tx;  ///< bytes for the instrument
  std::int64_t wake_us = 0;   ///< next wake wanted (absolute), 0 = none; an early wake does no harm
  bool reopen = false;        ///< close the port and open it again
  // Of a driver with two ports (Driver::has_line): the instrument's own.
  std::vector<std::byte> line_tx;
  bool reopen_line = false;
  std::vector<DriverEvent> events;

  /// @tparam Of the driver that measured
  template <class Of, class T>
  requires MeasurementOf<T, Of>
  void measured(T value) { events.emplace_back(Measured{std::move(value)}); }
  void clear() {
    tx.clear();
    wake_us = 0;
    reopen = false;
    line_tx.clear();
    reopen_line = false;
    events.clear();
  }
};

}  // namespace firn::drivers
