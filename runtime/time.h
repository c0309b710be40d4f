// Time holds node time: microseconds since the run's epoch. Nodes are given the time; they never ask for it.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>

namespace firn {

struct Time {
  std::int64_t us = 0;

  static constexpr Time never() { return {std::numeric_limits<std::int64_t>::max()}; }
  constexpr Time after_s(double s) const { return {us + std::int64_t(s * 1e6 + (s < 0 ? -0.5 : 0.5))}; }
  constexpr double s() const { return double(us) * 1e-6; }
  friend constexpr double seconds_between(Time a, Time b) { return double(b.us - a.us) * 1e-6; }
  constexpr auto operator<=>(const Time&) const = default;
};

/// Names a wake-up of one node; arming it again moves it.
enum class TimerId : std::uint32_t {};

/// Names a byte port of a driver ("stage", "jet", …): the index in the node's declared ports.
enum class PortId : std::uint32_t {};

enum class LinkState : std::uint8_t { kClosed, kOpen };

}  // namespace firn
