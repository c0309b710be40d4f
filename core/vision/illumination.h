// Illumination holds the smooth ground of one picture, its noise and the level of opaque objects.
#pragma once

#include <cstdint>
#include <vector>

#include "core/vision/frame.h"

namespace firn::vision {

inline constexpr int kBlock = 4;  ///< side of the blocks of pixels [px]

enum class Polarity { kAuto, kDark, kBright };  ///< objects against their ground

/// The smooth ground of a picture. All levels are of a picture whose objects are darker than the ground:
/// pictures of bright objects are inverted first.
struct Illumination {
  int columns = 0, rows = 0;             ///< blocks
  std::vector<float> ground;             ///< grey level of the ground in each block, rows from the top
  std::vector<std::uint16_t> min_pixel;  ///< of each block
  bool inverted = false;                 ///< objects are brighter than the ground
  bool empty = true;                     ///< nothing is darker than the ground
  double noise = 0.0;                    ///< standard deviation of one pixel [grey levels]
  double dark = 0.0;                     ///< grey level of opaque objects
  double depth = 0.0;                    ///< ground - dark, typical
  double opposite = 0.0;  ///< squared contrast of the weaker side of the ground over the other's
};

/// Fits the ground as a cubic in x and y to the medians of tiles, from the most frequent level outwards, so
/// that nozzle and droplets are outliers; then follows the tiles' remaining medians where they differ
/// slightly.
/// @param inverted is given the inverted picture when the objects are brighter than the ground, else left
/// alone
/// @pre is_valid(frame)
Illumination measure_illumination(const Frame& frame, Polarity polarity, Frame& inverted);

}  // namespace firn::vision
