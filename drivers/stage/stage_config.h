// StageConfig holds the settings of the stage, with range and meaning of each.
#pragma once

#include <array>
#include <cstdint>

#include "core/options/option.h"

namespace firn::drivers {

enum class HomeAtStart : std::uint8_t { kOn, kOff };
inline constexpr std::array<std::string_view, 2> kHomeAtStartWords{"on", "off"};
constexpr std::span<const std::string_view> words_of(HomeAtStart) { return kHomeAtStartWords; }

struct StageConfig {
  double counts_per_mm = 10000.0;
  double acceleration_mm_s2 = 5000.0;  ///< of moves; an ABORT brakes at least as hard
  double max_speed_mm_s = 300.0;
  double x_min_mm = -50.0, x_max_mm = 150.0;
  double y_min_mm = -50.0, y_max_mm = 150.0;
  double z_min_mm = -10.0, z_max_mm = 50.0;
  int array_limit = 8192;
  double poll_moving_s = 0.1;
  double poll_idle_s = 1.0;  ///< the controller closes an idle socket
  HomeAtStart home_at_start = HomeAtStart::kOn;
};
inline constexpr OptionTable kStageConfig{
    Option{"counts_per_mm", &StageConfig::counts_per_mm, "1/mm", within(1, 1e7), "encoder counts"},
    Option{"acceleration_mm_s2", &StageConfig::acceleration_mm_s2, "mm/s^2", above(0, 1e6), "ramp rate"},
    Option{"max_speed_mm_s", &StageConfig::max_speed_mm_s, "mm/s", above(0, 1e4), "of x and y"},
    Option{"x_min_mm", &StageConfig::x_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"x_max_mm", &StageConfig::x_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"y_min_mm", &StageConfig::y_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"y_max_mm", &StageConfig::y_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"z_min_mm", &StageConfig::z_min_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"z_max_mm", &StageConfig::z_max_mm, "mm", within(-1e4, 1e4), "soft limit"},
    Option{"array_limit", &StageConfig::array_limit, "", within(1, 1'000'000),
           "firing distances that the controller holds"},
    Option{"poll_moving_s", &StageConfig::poll_moving_s, "s", above(0, 10),
           "between status questions during a move"},
    Option{"poll_idle_s", &StageConfig::poll_idle_s, "s", above(0, 60), "between status questions at rest"},
    Option{"home_at_start", &StageConfig::home_at_start, "", Range{},
           "off: axes that are not homed stay so until a home command"},
};

}  // namespace firn::drivers
