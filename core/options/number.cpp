#include "core/options/number.h"

#include <charconv>
#include <cstdint>
#include <type_traits>

namespace firn {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Reads -?digits[.digits] of at most 15 digits, several times faster than from_chars: digits and power of
/// ten are exact doubles, and one division rounds correctly. Returns the end of the number, or nullptr.
const char* read_short_decimal(const char* at, const char* end, double& value) {
  static constexpr double kTen[16] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                      1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  const bool negative = at != end && *at == '-';
  if (negative) ++at;
  std::uint64_t digits = 0;
  const char* const first = at;
  for (; at != end && is_digit(*at); ++at) digits = 10 * digits + std::uint64_t(*at - '0');
  long count = at - first, places = 0;
  if (count == 0 || count > 15) return nullptr;
  if (at != end && *at == '.') {
    const char* const point = ++at;
    for (; at != end && is_digit(*at); ++at) digits = 10 * digits + std::uint64_t(*at - '0');
    places = at - point;
    count += places;
    if (places == 0 || count > 15) return nullptr;
  }
  const double size = double(digits) / kTen[places];
  value = negative ? -size : size;
  return at;
}

/// True for a float that is out of range by a negative exponent.
bool is_tiny(std::string_view number) {
  const std::size_t e = number.find_first_of("eE");
  return e != number.npos && e + 1 < number.size() && number[e + 1] == '-';
}

/// @param how a std::chars_format, or the base of an integer
template <class T, class How>
std::optional<T> taken(std::string_view& text, How how) {
  std::string_view number = text;
  if (number.starts_with('+')) {  // from_chars() does not take it
    number.remove_prefix(1);
    if (number.starts_with('-')) return {};
  }
  T value{};
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value, how);
  const std::size_t length = std::size_t(end - number.data());
  if constexpr (std::is_floating_point_v<T>) {
    if (error == std::errc::result_out_of_range && is_tiny(number.substr(0, length)))
      value = T{};
    else if (error != std::errc{} || !(value - value == T{}))  // nan, inf
      return {};
  } else if (error != std::errc{}) {
    return {};
  }
  text = number.substr(length);
  return value;
}

}  // namespace

template <class T>
std::optional<T> take_number(std::string_view& text, Exponent exponent) {
  if constexpr (std::is_floating_point_v<T>)
    return taken<T>(text,
                    exponent == Exponent::kRead ? std::chars_format::general : std::chars_format::fixed);
  else
    return taken<T>(text, 10);
}

template <class T>
std::optional<T> whole_number(std::string_view text) {
  if constexpr (std::is_same_v<T, double>) {
    double value = 0.0;
    const char* const end = text.data() + text.size();
    if (!text.empty() && read_short_decimal(text.data(), end, value) == end) return value;
  }
  const std::optional<T> value = take_number<T>(text);
  return text.empty() ? value : std::nullopt;
}

template <class T>
std::optional<T> whole_hex_number(std::string_view text) {
  const std::optional<T> value = taken<T>(text, 16);
  return text.empty() ? value : std::nullopt;
}

std::optional<std::uint8_t> hex_byte(std::string_view text) {
  return text.size() == 2 && text[0] != '+' ? whole_hex_number<std::uint8_t>(text) : std::nullopt;
}

#define FIRN_NUMBER(T)                                      \
  template std::optional<T> whole_number(std::string_view); \
  template std::optional<T> take_number(std::string_view&, Exponent);
#define FIRN_INTEGER(T) \
  FIRN_NUMBER(T)        \
  template std::optional<T> whole_hex_number(std::string_view);
FIRN_INTEGER(std::int32_t)
FIRN_INTEGER(std::int64_t)
FIRN_INTEGER(std::uint8_t)
FIRN_INTEGER(std::uint16_t)
FIRN_INTEGER(std::uint32_t)
FIRN_INTEGER(std::uint64_t)
FIRN_NUMBER(float)
FIRN_NUMBER(double)

}  // namespace firn
