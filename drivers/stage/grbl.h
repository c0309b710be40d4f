// GrblDialect encodes and frames the lines of GRBL 1.1, serial 115200 8N1: a line of G-code, answered by "ok"
// or "error:N"; real-time bytes without an end, of which "?" is answered by
// "<Idle|MPos:0.000,0.000,0.000|…>"; lines that come by themselves. Sources: gnea/grbl
// doc/markdown/interface.md and its code [C] (docs/devices/grbl.md).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::grbl {

inline constexpr char kHold = '!', kStatus = '?', kReset = '\x18';

/// Numbers of its settings ($N); those from kSteps on are of X, with Y and Z behind.
enum Setting : int {
  kInches = 13,
  kHoming = 22,
  kMaxPower = 30,
  kLaserMode = 32,
  kSteps = 100,         ///< per mm
  kMaxRate = 110,       ///< [mm/min]
  kAcceleration = 120,  ///< [mm/s^2]
};

enum Format : std::uint8_t { kOk, kReport, kWelcome };

enum class State : std::uint8_t {
  kIdle,
  kRun,
  kHoldComplete,
  kHolding,
  kJog,
  kAlarm,
  kDoor,
  kCheck,
  kHome,
  kSleep
};

/// A status report. The place is that of the work coordinates, or of the machine with the offset between both
/// where the report tells it.
struct Report {
  State state = State::kIdle;
  std::array<double, 3> place_mm{};
  bool of_machine = false;
  std::optional<std::array<double, 3>> offset_mm = {};  ///< work = machine - offset
};

/// Returns nothing for a line that is none: damaged, or of another version.
std::optional<Report> parse_report(std::string_view line);

/// Returns number and value of "$110=500.000".
std::optional<std::pair<int, double>> parse_setting(std::string_view line);

/// Returns the meaning of an "error:N" or "ALARM:N": "error 9: locked by an alarm".
std::string meaning_of(std::string_view line);

class GrblDialect final : public Dialect {
 public:
  GrblDialect();
  char line_end() const override { return '\n'; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
};

/// A line, without its end.
Request line(std::string_view text, std::uint16_t tag, Repeat repeat, std::int64_t reply_us = 0);
Request status(std::uint16_t tag);
Request reset(std::uint16_t tag);

/// Returns the text of a frame without its end.
std::string_view text_of_line(std::span<const std::byte> frame);

/// Returns the number as the printf format of one double writes it.
std::string fixed(const char* format, double value);

LinkProbe link_probe();

}  // namespace firn::drivers::grbl
