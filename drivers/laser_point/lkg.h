// LkgDialect encodes and frames the lines of the Keyence LK-G3001P, RS-232: lines that end with CR, one
// command and then its reply, which begins with the command's name (docs/devices/laser_point.md). No
// checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/laser_point/laser_point_config.h"
#include "drivers/link/dialect.h"
#include "drivers/link/link_probe.h"

namespace firn::drivers::lkg {

/// Meaning of the characters in a value's place.
enum class Status : std::uint8_t {
  kOk,
  kNoValue,  ///< XXXXXXXX, the panel shows dashes
  kAbove,    ///< +FFFFFFF
  kBelow,    ///< -FFFFFFF
  kDamaged   ///< nothing that the manual lists
};

struct Value {
  Status status = Status::kNoValue;
  double mm = std::numeric_limits<double>::quiet_NaN();  ///< a number only where status is kOk
};
inline constexpr std::size_t kValueChars = 8;  ///< sign and seven characters, the digits to the right
/// @param chars of a number; the texts without a number have kValueChars on every model
Value parse_value(std::string_view text, std::size_t chars = kValueChars);

using Table = LaserPointDialect;
/// Sampling codes of Table::sampling [us].
inline constexpr int kSampling_us[6] = {20, 50, 100, 200, 500, 1000};
/// Codes of the storage cycle in Table::storage: every 1, 2, 5, 10, … samples [P].
inline constexpr int kCycles[10] = {1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};
/// Code with kCycles[code] = samples, or -1.
int cycle_code(int samples);

/// A command (without CR) as a request. @param reply_us longest wait for the reply, 0 = the dialect.s
Request request(std::string_view command, Repeat repeat, std::uint16_t tag, std::int64_t reply_us = 0);

/// Classifies a reply line (without CR) to the command `command` (without CR).
struct Reply {
  enum class Kind : std::uint8_t {
    kForeign,  ///< of another command, or damaged
    kDone,     ///< `rest` follows the command's name, without the comma
    kError,    ///< `ER,<command or a setting's identifier>,<nn>`: 00 command, 01 status, 20 length, 21 count,
               ///< 22 parameter, 88 timeout, 99 other
    kTiming    ///< `TG,…`: came by itself
  };
  Kind kind = Kind::kForeign;
  int error = 0;
  std::string_view rest;
};
Reply parse(std::string_view line, std::string_view command);

struct Stored {
  bool storing = false;
  int values = 0;
};
/// @param rest with the values of one output or of both; output 1 counts
std::optional<Stored> parse_stored(std::string_view rest);
/// Values of a dump as floats, NaN where there is none; reuses the storage of `mm`. @returns the damaged
/// ones, which are NaN too, or nothing when the line is no list of values of `chars` characters.
std::optional<int> parse_dump(std::string_view rest, std::vector<float>& mm, std::size_t chars = kValueChars);

class LkgDialect : public Dialect {
 public:
  LkgDialect();
  char line_end() const override { return '\r'; }
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;

  Table table;
};

LinkProbe link_probe();

}  // namespace firn::drivers::lkg
