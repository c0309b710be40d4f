#include "core/options/range.h"

#include <array>
#include <charconv>
#include <cmath>

#include "core/options/option.h"
#include "core/options/require.h"

namespace firn {

std::string shortest_text(double value) {
  if (value == 0.0) return "0";
  std::array<char, 40> buffer;
  return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
}

std::string text(const Range& range) {
  if (!std::isfinite(range.min)) return "";
  return (range.or_zero ? "0 or " : "") + std::string(range.min_excluded ? "(" : "[") +
         shortest_text(range.min) + ", " + shortest_text(range.max) + "]";
}

void detail::check_number(std::string_view where, std::string_view prefix, std::string_view name,
                          double value, const Range& range) {
  if (!range.holds(value))
    refuse(where, std::string(prefix) + std::string(name) + " = " + shortest_text(value) + " is outside " +
                      text(range));
}

}  // namespace firn
