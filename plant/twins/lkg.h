// Writes replies of the Keyence LK-G3001P as its manual has them (docs/devices/laser_point.md).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace firn::plant::lkg {

inline constexpr std::int32_t kMaxStored = 65536;
inline constexpr std::int32_t kMaxAveraging = 9, kMaxMaterial = 4, kMaxProgram = 7;
inline constexpr std::array<std::int32_t, 6> kSampling_us{20, 50, 100, 200, 500, 1000};  ///< SW,CA
/// Of SW,CI: one value is stored every so many samples.
inline constexpr std::array<std::int32_t, 10> kStoringCycles{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};

enum class Error : std::uint8_t { kCommand = 0, kStatus = 1, kParameter = 22 };
/// Returns `ER,<command>,<nn>`; a setting is named by its identifier, HB for `SW,HB,1,4`.
std::string refused(std::string_view line, Error error);

/// Returns a sign, two digits, a point and four digits [mm]; -FFFFFFF and +FFFFFFF beyond what these hold,
/// XXXXXXXX for no value (NaN).
std::string value(double mm);

}  // namespace firn::plant::lkg
