// The table of interlocks in words: cause, remedy and place in the manual of each fault code of
// docs/safety.md.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace firn::page {

struct InterlockWords {
  int code;
  std::string_view cause;
  std::string_view remedy;
  std::string_view limits = {};  ///< keys of the settings that set its limits, with commas
};

inline constexpr std::string_view kInterlockPage = "/manual/safety.html#interlock-";  ///< and its code
inline constexpr std::string_view kDoubtPage = "/manual/safety.html#deposit-at-most-once";
inline constexpr std::string_view kStopPage = "/manual/safety.html#the-stop";
/// The remedy of a fault that is no interlock.
inline constexpr std::string_view kResume =
    "find the cause, make the lab safe, then: firn print --resume RUN";

std::span<const InterlockWords> interlocks();

/// @returns nullptr for a code without a row: 0 = no interlock
const InterlockWords* interlock_words(int code);

}  // namespace firn::page
