// LaserProfilerConfig holds the settings of the laser profiler, with range and meaning of each.
#pragma once

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

/// Direction of the instrument's z. up: a greater value is a higher surface.
enum class ZSign : std::uint8_t { kUp, kDown };
inline constexpr std::array<std::string_view, 2> kZSignWords{"up", "down"};
constexpr std::span<const std::string_view> words_of(ZSign) { return kZSignWords; }

/// newest: the driver asks for the newest profile; one that is overwritten before is lost. memory: it asks
/// for every profile by its number, from the instrument's memory, several in one reply.
enum class ProfileRead : std::uint8_t { kNewest, kMemory };
inline constexpr std::array<std::string_view, 2> kProfileReadWords{"newest", "memory"};
constexpr std::span<const std::string_view> words_of(ProfileRead) { return kProfileReadWords; }

struct LaserProfilerConfig {
  int points = 800;
  double dx_mm = 0.0;        ///< 0 = chosen so that the line covers the grid
  double offset_y_mm = 0.0;  ///< line relative to the nozzle
  double offset_x_mm = 0.0;  ///< of the head's centre
  OnOff mirror_x = OnOff::kOff;
  ZSign z_sign = ZSign::kUp;
  double z_zero_mm = 0.0;
  int program = 0;
  ProfileRead read = ProfileRead::kNewest;
  double bias_limit_mm = 0.005;  ///< calibrated uncertainty of heights; 0: the bare table is not checked
  double offset_limit_mm = 0.2;  ///< and of places; 0: the first layer's outline is not checked
  double poll_s = 0.004;  ///< while armed; must be shorter than the time between two triggers. Once two rows
                          ///< have come, the driver waits 9/10 of their distance before it asks again.
};
inline constexpr OptionTable kLaserProfilerConfig{
    Option{"points", &LaserProfilerConfig::points, "", within(2, 800), "points of one profile"},
    Option{"dx_mm", &LaserProfilerConfig::dx_mm, "mm", within(0, 10),
           "distance of points; 0 = so that the line covers the grid"},
    Option{"offset_y_mm", &LaserProfilerConfig::offset_y_mm, "mm", within(-1000, 1000),
           "laser line relative to the nozzle"},
    Option{"offset_x_mm", &LaserProfilerConfig::offset_x_mm, "mm", within(-1000, 1000),
           "part x of the head's centre, from which the instrument counts x [C]"},
    Option{"mirror_x", &LaserProfilerConfig::mirror_x, "", Range{},
           "on: the instrument's x grows towards smaller part x [C]"},
    Option{"z_sign", &LaserProfilerConfig::z_sign, "", Range{},
           "up: a greater value is a higher surface; down: a lower one [C]"},
    Option{"z_zero_mm", &LaserProfilerConfig::z_zero_mm, "mm", within(-1000, 1000),
           "the instrument's value at part height 0 [C]"},
    Option{"program", &LaserProfilerConfig::program, "", within(0, 15), "program that is switched to"},
    Option{"read", &LaserProfilerConfig::read, "", Range{},
           "newest: a profile that is overwritten before it is read is lost; memory: all are read by number "
           "[S]"},
    Option{"bias_limit_mm", &LaserProfilerConfig::bias_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of heights (interlock 15); 0 = not checked"},
    Option{"offset_limit_mm", &LaserProfilerConfig::offset_limit_mm, "mm", within(0, 100),
           "calibrated uncertainty of places (interlock 15); 0 = not checked"},
    Option{"poll_s", &LaserProfilerConfig::poll_s, "s", above(0, 10), "between questions for a new profile"},
};

}  // namespace firn::drivers
