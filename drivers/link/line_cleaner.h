// LineCleaner removes the bytes of a text protocol that mean nothing: line ends of the other convention,
// blank lines, padding by NUL, backspace or blanks, and the commands of a serial server in Telnet mode (RFC
// 854). A byte within a word stays where it is, so that a damaged number is still seen to be damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::drivers {

class LineCleaner {
 public:
  /// Appends the bytes that mean something to `out`, each line with `end` alone behind it. The pieces of a
  /// stream may be cut anywhere.
  /// @param end CR or LF: both become this one; another character: CR and LF are padding
  void clean(std::span<const std::byte> bytes, char end, std::vector<std::byte>& out);

 private:
  enum class Telnet : std::uint8_t { kText, kCommand, kOption, kSub, kSubCommand };

  bool take_telnet(std::uint8_t byte, char end, std::vector<std::byte>& out);
  void take_text(char c, char end, std::vector<std::byte>& out);

  bool at_start_ = true;      // of a line
  std::string padding_;       // met within a line: it stays if a word goes on behind it
  bool blank_before_ = true;  // the padding follows a blank
  Telnet telnet_ = Telnet::kText;
};

/// The whole of `heard`, cleaned.
std::string cleaned(std::string_view heard, char end);

/// Returns "'A +014.70'": the first 80 bytes, those that cannot be shown as \x00.
std::string shown_line(std::string_view bytes);

}  // namespace firn::drivers
