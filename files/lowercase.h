// lowercase() returns a text in small letters, of ASCII alone.
#pragma once

#include <string>
#include <string_view>

namespace firn {

inline std::string lowercase(std::string_view text) {
  std::string low(text);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return low;
}

}  // namespace firn
