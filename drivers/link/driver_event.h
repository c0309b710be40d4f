// What a driver tells its node, and what one step of a driver wants done. The numbers of the enums are those
// of device_state_t and answer_t.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace firn::drivers {

enum class DriverState : std::int8_t {
  kDisconnected,
  kConnecting,
  kIdentifying,
  kSafe,  ///< idle, nothing can move or fire
  kStaged,
  kArmed,
  kActive,
  kSuspect,  ///< a reply did not come or was damaged: the link is drained and probed before it is used again
  kFault,    ///< latched: only a new connection leaves it
  kEstop,
};
const char* name(DriverState state);

enum class Outcome : std::int8_t {
  kReady,  ///< armed
  kDone,
  kNone,     ///< nothing physical happened
  kUnknown,  ///< [unknown_from, unknown_to) may or may not have happened
  kRefused,  ///< not started; nothing was sent to the instrument
  kFailed,   ///< ended early; `counted` is exactly what happened (a prefix of the firing order)
};
const char* name(Outcome outcome);

/// Interlock numbers of docs/interlocks.md that drivers raise.
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
  DriverState state = DriverState::kDisconnected;
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
};

struct Progress {
  std::int32_t rows_done = 0;
  std::int32_t rows = 0;
  std::int64_t counted = 0;
};

struct Fault {
  int severity = 1;  ///< 0 notice, 1 warning, 2 stop the print safely
  std::int32_t code = kNoCode;
  std::string text;
};

/// One line of the laser profiler.
struct Profile {
  std::int32_t row = 0;  ///< 0-based row of the scan
  double x0_mm = 0.0;
  double dx_mm = 0.0;
  std::uint32_t trigger_count = 0;
  std::int32_t encoder_count = 0;
  std::vector<float> z_mm;  ///< NaN = no valid sample
};

/// All rows are there, or the scan was ended.
struct ScanDone {
  std::int32_t rows_expected = 0;
  std::int32_t rows_received = 0;
};

/// What the point laser stored, or one reading.
struct Samples {
  std::int32_t material = 0;
  std::int32_t expected = 0;  ///< asked for; 1 = a single reading
  std::int32_t damaged = 0;   ///< of the values, for a reason that the instrument does not give
  double period_s = 0.0;
  std::vector<float> z_mm;  ///< from the reference distance, up positive; NaN = no value
};

/// The heater's temperatures and what is wrong with them.
struct Temperatures {
  std::array<double, 3> celsius{};  ///< NaN = open thermocouple
  std::array<double, 3> set_celsius{};
  std::array<std::int8_t, 3> fault{};  ///< numbers of temperature_t
  std::array<bool, 3> heating{};
};

using DriverEvent =
    std::variant<StateChange, Result, Progress, Fault, Profile, ScanDone, Samples, Temperatures>;

/// Filled by every call of a driver; the caller clears it and hands it in again, so that a steady state
/// allocates nothing.
struct Effects {
  std::vector<std::byte> tx;  ///< bytes for the instrument
  std::int64_t wake_us = 0;   ///< next wake wanted (absolute), 0 = none; an early wake does no harm
  bool reopen = false;        ///< close the port and open it again
  std::vector<DriverEvent> events;

  void clear() {
    tx.clear();
    wake_us = 0;
    reopen = false;
    events.clear();
  }
};

}  // namespace firn::drivers
