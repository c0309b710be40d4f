// require() throws std::invalid_argument with the name of the part that refuses an argument.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace firn {

/// @throws std::invalid_argument "<where>: <what>"
[[noreturn]] inline void refuse(std::string_view where, std::string_view what) {
  throw std::invalid_argument(std::string(where) + ": " + std::string(what));
}

/// @throws std::invalid_argument "<where>: <what>" unless ok
inline void require(bool ok, std::string_view where, std::string_view what) {
  if (!ok) refuse(where, what);
}

}  // namespace firn
