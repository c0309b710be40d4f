// ThermostatDialect encodes and frames the lines of the end effector's three ON/OFF temperature controllers,
// seen as one read-out box [P]: the thesis's controllers have no interface (docs/devices/heater.md). Lines
// `<text>*<CRC4>\r\n` both ways, CRC-16/CCITT-FALSE over the text:
//   `T?`            -> `T,<t1>,<t2>,<t3>,<relays>`   0.01 degC, or OPEN for an open thermocouple; relays =
//   bits of
//                                                    the heating coils that are on
//   `S,<ch>,<c100>` -> the same line                 set point of channel 1, 2, 3; kOff = off
// A refused line is answered with `E,<code>`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "drivers/link/checked_line.h"
#include "drivers/link/line_dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::thermostat {

inline constexpr int kChannels = 3;
inline constexpr std::int32_t kOff_c100 = -5000;  ///< a set point that no heater reaches

struct Reading {
  std::array<double, kChannels> celsius{};  ///< NaN = open thermocouple
  std::array<bool, kChannels> heating{};
};

/// Longest and shortest that are believed; anything else is damage.
inline constexpr double kLowest_degC = -100.0, kHighest_degC = 400.0;

std::optional<Reading> parse_reading(std::string_view text);  ///< text as checked_text(line, 0)

struct SetPoint {
  int channel = 1;
  std::int32_t c100 = kOff_c100;
  bool operator==(const SetPoint&) const = default;
};
void put(LineWriter& line, const SetPoint& set);

Request read_request(std::uint16_t tag);
Request set_request(const SetPoint& set, std::uint16_t tag);

class ThermostatDialect : public LineDialect {
 public:
  ThermostatDialect();
  Request probe() const override;

 private:
  std::optional<std::string_view> body(std::string_view line) const override;
  bool answers(std::string_view body, const Request& asked) const override;
};

LinkProbe link_probe();

}  // namespace firn::drivers::thermostat
