// AlicatDialect encodes and frames the lines of Alicat mass-flow controllers: several units on one line, each
// with an id of one letter, 19200 8N1, CR at the end both ways [C: docs/devices/gas.md]. Poll `A` ->
// `A +014.70 +025.00 +00.000 +00.000 +00.000     N2`: pressure, temperature, volume flow, mass flow, set
// point, perhaps a total, gas, perhaps codes of three letters. A refusal is `?`.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/gas/gas_config.h"
#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::alicat {

/// Codes behind the gas of a data frame.
enum Code : std::uint16_t {
  kAdcError = 1 << 0,         ///< ADC
  kExhaust = 1 << 1,          ///< EXH
  kHold = 1 << 2,             ///< HLD: the valve stays where it is, whatever the set point
  kLocked = 1 << 3,           ///< LCK: the buttons only
  kMassOver = 1 << 4,         ///< MOV
  kOverPressure = 1 << 5,     ///< OPL
  kTotalOver = 1 << 6,        ///< OVR
  kPressureOver = 1 << 7,     ///< POV
  kTemperatureOver = 1 << 8,  ///< TOV
  kVolumeOver = 1 << 9,       ///< VOV
  kTotalMissed = 1 << 10,     ///< TMF
};
/// The values of a frame with one of these are beyond its range, or its valve does not follow.
inline constexpr std::uint16_t kUntrusted =
    kAdcError | kExhaust | kHold | kMassOver | kOverPressure | kPressureOver | kTemperatureOver | kVolumeOver;
/// "MOV HLD"; empty: none.
std::string names_of(std::uint16_t codes);

/// In the units that the instrument displays.
struct Reading {
  char unit = 'A';
  double pressure = 0.0, temperature_degC = 0.0, volume_flow = 0.0, mass_flow = 0.0;
  double set_point = 0.0;
  double resolution = 0.0;  ///< of the set point as shown
  std::string_view gas;     ///< part of the line
  std::uint16_t codes = 0;
};
/// @param line without its CR @returns nothing: no data frame of a controller
std::optional<Reading> parse_reading(std::string_view line);

enum Format : std::uint8_t { kData, kVersion, kInfo };

/// Unit and prefix: firmware GP wants "$$" before every command [S].
struct Unit {
  char id = 'A';
  bool dollars = false;
};
Request poll_request(Unit unit, std::uint16_t tag);
Request version_request(Unit unit, const GasDialect& texts, std::uint16_t tag);
Request info_request(Unit unit, const GasDialect& texts, std::uint16_t tag);
/// @param value in the units that the instrument displays
Request set_request(Unit unit, double value, const GasDialect& texts, std::uint16_t tag);

/// The lines of a reply, without their line ends.
std::string_view text_of(std::span<const std::byte> frame);
bool is_refusal(std::string_view line);

class AlicatDialect : public Dialect {
 public:
  AlicatDialect();
  char line_end() const override { return '\r'; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;

  char probed = 'A';  ///< unit that is asked after a lost reply
};

LinkProbe link_probe();

}  // namespace firn::drivers::alicat
