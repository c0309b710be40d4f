#include "plant/twins/lines.h"

#include "core/options/number.h"

namespace firn::plant {

RemainderCcitt& RemainderCcitt::add(std::string_view bytes) {
  for (const char c : bytes)
    for (int bit = 7; bit >= 0; --bit) {
      const bool leaves = (register_ >> 15) != 0;
      const bool enters = (std::uint8_t(c) >> bit & 1) != 0;
      register_ = std::uint16_t(register_ << 1);
      if (leaves != enters) register_ = std::uint16_t(register_ ^ 0x1021);
    }
  return *this;
}

std::string hex4(std::uint16_t value) {
  std::string digits;
  for (int shift = 12; shift >= 0; shift -= 4) digits += "0123456789ABCDEF"[value >> shift & 15];
  return digits;
}

std::string sealed(std::string_view text) {
  return std::string(text) + '*' + hex4(RemainderCcitt().add(text).value()) + "\r\n";
}

std::optional<std::string_view> unsealed(std::string_view line) {
  constexpr std::size_t kTail = 7;  // the star, four digits, CR LF
  if (line.size() < kTail || line[line.size() - kTail] != '*') return std::nullopt;
  const std::string_view text = line.substr(0, line.size() - kTail);
  if (sealed(text) != line) return std::nullopt;
  return text;
}

std::string_view Words::next() {
  const std::size_t end = rest_.find(' ');
  const std::string_view word = rest_.substr(0, end);
  more_ = end != std::string_view::npos;
  rest_ = more_ ? rest_.substr(end + 1) : std::string_view();
  return word;
}

std::int64_t Words::integer(std::int64_t least, std::int64_t most) {
  const std::optional<std::int64_t> value = whole_number(next(), least, most);
  if (!value) good_ = false;
  return value.value_or(0);
}

}  // namespace firn::plant
