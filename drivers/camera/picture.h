// Picture holds one grey picture as a camera gave it.
#pragma once

#include <cstdint>
#include <vector>

namespace firn::drivers {

/// Limits of a picture's sides [px].
inline constexpr std::int32_t kMinPicture_px = 16, kMaxPicture_px = 16384;

struct Picture {
  std::int32_t width = 0, height = 0;
  std::int32_t white = 255;           ///< the largest value that a pixel can take
  std::int64_t age_us = 0;            ///< from the exposure to the reply
  std::vector<std::uint16_t> pixels;  ///< rows from the top
};

}  // namespace firn::drivers
