// BusKey holds the secret of one start of a run. Its launcher makes it and hands it to every process on the
// bus by the control line, never by a file, an argument or the environment. docs/security.md
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/process_args.h"

namespace firn {

struct BusKey {
  std::array<std::byte, 32> bytes{};

  /// Returns a key from the kernel's random numbers. @throws std::runtime_error if there are none
  static BusKey random();
  /// Returns the first line that the launcher sends down a control line: "KEY " and 64 hexadecimal digits.
  std::string line() const;
  std::string hex() const;  ///< its 64 hexadecimal digits
  /// Nothing unless `line` is such a line.
  static std::optional<BusKey> from_line(std::string_view line);
};

/// Channels of the lab's own programs begin with this: "own/NAME/CHANNEL". docs/own-lcm-program.md
inline constexpr std::string_view kOwnPrefix = "own/";
/// Returns NAME of such a channel; of another channel, or without a CHANNEL behind it, an empty text.
std::string_view own_program_of(std::string_view channel);

/// Whether the messages of the bus at `url` are authenticated: unless it has the option key=none.
bool bus_is_keyed(std::string_view url);

/// Reads the key of a process from its control line, and no byte more. Nothing, with a sentence on stderr, if
/// the bus has the option key=none. @throws std::runtime_error naming the remedy if no key comes
std::optional<BusKey> take_bus_key(const ProcessArgs& args);

}  // namespace firn
