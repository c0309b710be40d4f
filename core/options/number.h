// whole_number() and take_number() read the numbers in texts that other programs, instruments and people
// write.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace firn {

/// Returns the number that is the whole of `text`: a sign, + or -, digits, and for float and double a decimal
/// point and an exponent. Returns nothing for an empty text, for text beside the number (blanks, "2,5",
/// "2.5mm", "1e"), for "nan", "inf" and hexadecimal floats, and for a number that T does not hold. A float or
/// double nearer to 0 than T distinguishes is 0.
/// @tparam T float, double, or an integer of 8 (unsigned), 16 (unsigned), 32 or 64 bits
template <class T>
std::optional<T> whole_number(std::string_view text);

/// The same for a number in [low, high] only.
template <class T>
std::optional<T> whole_number(std::string_view text, T low, T high) {
  const std::optional<T> value = whole_number<T>(text);
  return value && *value >= low && *value <= high ? value : std::nullopt;
}

/// The same for an integer without 0x before it.
template <class T>
std::optional<T> whole_hex_number(std::string_view text);

/// Returns the byte that two hexadecimal digits write, without a sign; nothing for any other text.
std::optional<std::uint8_t> hex_byte(std::string_view text);

/// Says whether "1E2" is 100, or 1 and the word E2 of G-code.
enum class Exponent { kRead, kLeft };

/// Returns the number at the start of `text` and removes it from there, for languages in which numbers follow
/// each other: "10-5" holds 10 and -5, "2.5mm" holds 2.5. The caller must look at the next character. Returns
/// nothing, and leaves `text` as it is, where whole_number() would refuse the number itself.
template <class T>
std::optional<T> take_number(std::string_view& text, Exponent exponent = Exponent::kRead);

}  // namespace firn
