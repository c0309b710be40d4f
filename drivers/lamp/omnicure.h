// OmnicureDialect encodes and frames the lines of the Excelitas OmniCure S2000, RS-232 19200 8N1 without flow
// control: `<text><CRC-8 as two hex digits>\r` both ways. Sources: the manual and two public codebases
// (docs/devices/lamp.md).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "drivers/lamp/lamp_config.h"
#include "drivers/link/line_dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::omnicure {

/// CRC-8 of Dallas/Maxim: reflected polynomial 8Ch, initial value 0.
std::uint8_t crc8(std::string_view text);

/// `text` with its CRC and the carriage return.
std::string frame(std::string_view text);

using Table = LampDialect;

/// Bits of the integer that answers GUS [S].
enum Status : std::uint32_t {
  kAlarm = 1u << 0,
  kBurning = 1u << 1,
  kShutterOpen = 1u << 2,
  kShutterFault = 1u << 3,
  kWarm = 1u << 4,
  kExposureFault = 1u << 7,
};
/// The reason against an exposure with these bits, warmth apart; "" = none.
std::string_view trouble(std::uint32_t status);

enum Format : std::uint8_t { kReceived, kReady, kClosed, kAny };

class OmnicureDialect : public LineDialect {
 public:
  OmnicureDialect();
  Request probe() const override;
  /// The text of a good frame, without CRC and end.
  static std::string_view text(std::span<const std::byte> frame);

  Table table;

 private:
  /// A line whose CRC is wrong is never a reply. Err is a reply to anything.
  std::optional<std::string_view> body(std::string_view line) const override;
  bool answers(std::string_view body, const Request& asked) const override;
};

Request request(std::string_view text, Format format, Repeat repeat, std::uint16_t tag);

/// Returns whether these bytes are one line: a text, two hex digits that are its CRC, CR.
bool is_line(std::string_view bytes);

LinkProbe link_probe();

}  // namespace firn::drivers::omnicure
