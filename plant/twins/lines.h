// Reads and writes lines of text that carry a checksum, as the heater box and the robot's V+ program do
// (docs/devices/heater.md, docs/devices/robot.md). Written from these pages: nothing of it is the drivers'.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace firn::plant {

/// Computes CRC-16/CCITT-FALSE: the remainder by x^16 + x^12 + x^5 + 1 of the bytes, highest bit first, with
/// the register at FFFF before the first; "123456789" has 29B1.
class RemainderCcitt {
 public:
  RemainderCcitt& add(std::string_view bytes);
  std::uint16_t value() const { return register_; }

 private:
  std::uint16_t register_ = 0xFFFF;
};

/// Returns four capital hex digits.
std::string hex4(std::uint16_t value);

/// Returns `text*CRC4` CR LF.
std::string sealed(std::string_view text);

/// Returns the text of such a line, or nothing where CRC, star or line end are not as they must be.
std::optional<std::string_view> unsealed(std::string_view line);

/// Takes a text apart into words with one space between two.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text), more_(!text.empty()) {}
  bool more() const { return more_; }
  std::string_view next();  ///< empty at the end
  /// Returns the next word as a whole number of `least` to `most`. Anything else returns 0, and good() is
  /// false from then on.
  std::int64_t integer(std::int64_t least, std::int64_t most);
  bool good() const { return good_; }

 private:
  std::string_view rest_;
  bool more_, good_ = true;
};

}  // namespace firn::plant
