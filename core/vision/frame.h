// Frame holds one grey picture of a camera: pixels in, droplets out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace firn::vision {

/// Limits of a picture's sides [px]: smaller ones hold no droplet, larger ones overflow 32-bit sums.
inline constexpr int kMinSide = 16, kMaxSide = 16384;

/// Rows from the top, x to the right, y down. Pixel (0, 0) has its centre at x = 0, y = 0.
struct Frame {
  int width = 0, height = 0;
  int white = 255;  ///< the largest value that a pixel can take: 255, 1023, 4095, 65535
  std::vector<std::uint16_t> pixels;

  std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(width) + std::size_t(x); }
  std::uint16_t at(int x, int y) const { return pixels[index(x, y)]; }
};

/// @returns false for sides outside the limits, a white level outside [1, 65535] or another number of pixels
inline bool is_valid(const Frame& f) {
  return f.width >= kMinSide && f.height >= kMinSide && f.width <= kMaxSide && f.height <= kMaxSide &&
         f.white >= 1 && f.white <= 65535 && f.pixels.size() == std::size_t(f.width) * std::size_t(f.height);
}

struct Point {
  double x = 0.0, y = 0.0;
};

}  // namespace firn::vision
