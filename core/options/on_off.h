// OnOff is the value of an option that is switched on or off.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace firn {

enum class OnOff : std::uint8_t { kOn, kOff };
inline constexpr std::array<std::string_view, 2> kOnOffWords{"on", "off"};
constexpr std::span<const std::string_view> words_of(OnOff) { return kOnOffWords; }
constexpr bool on(OnOff v) { return v == OnOff::kOn; }

}  // namespace firn
