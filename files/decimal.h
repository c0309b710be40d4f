// read_short_decimal converts short decimal numbers to doubles, exactly.
#pragma once

#include <cstdint>

namespace firn {

/// Reads -?digits[.digits] from [at, end). Returns the end of the number, or nullptr if there is no number or
/// more than 15 digits. Up to 15 digits, digits and power of ten are exact doubles, and one division rounds
/// as strtod does.
inline const char* read_short_decimal(const char* at, const char* end, double& value) {
  static constexpr double kTen[16] = {1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                      1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  const bool negative = at != end && *at == '-';
  if (negative) ++at;
  std::uint64_t digits = 0;
  const char* const first = at;
  for (; at != end && *at >= '0' && *at <= '9'; ++at) digits = 10 * digits + std::uint64_t(*at - '0');
  long count = at - first, places = 0;
  if (count == 0 || count > 15) return nullptr;
  if (at != end && *at == '.') {
    const char* const point = ++at;
    for (; at != end && *at >= '0' && *at <= '9'; ++at) digits = 10 * digits + std::uint64_t(*at - '0');
    places = at - point;
    count += places;
    if (places == 0 || count > 15) return nullptr;
  }
  const double size = double(digits) / kTen[places];
  value = negative ? -size : size;
  return at;
}

}  // namespace firn
