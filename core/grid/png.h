// Reads and writes PNG bytes by libpng [RFC 2083]. Rows from the top.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

struct PngError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct GreyPicture {
  int width = 0, height = 0;
  double white = 1.0;  ///< value of a white pixel; black is 0
  std::vector<double> pixels;
  double at(int x, int y) const { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

/// Width, height and colour type have fixed offsets, so that a forged header is known before memory is taken.
struct PngHeader {
  std::uint32_t width = 0, height = 0;
  int colour = 0;  ///< 0 = grey without alpha or palette
};
/// @throws PngError: is not a PNG file
PngHeader png_header(std::span<const std::byte> png);

/// Of 1 to 16 bits per pixel, as stored: no gamma is applied. @throws PngError: damaged, or no grey picture
GreyPicture read_grey_png(std::span<const std::byte> png);

/// Grey, 8 bits a pixel, or 16 where white > 255. Written fast rather than small.
/// @throws PngError: more pixels than memory
std::vector<std::byte> write_grey_png(int width, int height, int white,
                                      std::span<const std::uint16_t> pixels);

/// @param pixels `channels` bytes each, 3 = RGB, 4 = RGBA. @throws PngError: more pixels than memory
std::vector<std::byte> write_png(int width, int height, int channels, std::span<const std::uint8_t> pixels);

}  // namespace firn
