// Converts the pixels of grey V4L2 formats, and the luminance of YUYV, to grey levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::camera {

/// One pixel format. kWord: 16 bits, low byte first, of which the low ones count.
struct PixelFormat {
  enum class Layout : std::uint8_t { kByte, kWord, kYuyv };
  std::string_view name;     ///< as in a port's address: "Y12"
  std::uint32_t fourcc = 0;  ///< V4L2_PIX_FMT_…
  Layout layout = Layout::kByte;
  int white = 255;
};

/// GREY, Y10, Y12, Y16 and YUYV, the deepest first.
std::span<const PixelFormat> pixel_formats();
const PixelFormat* pixel_format(std::uint32_t fourcc);  ///< nullptr: none of them
const PixelFormat* pixel_format(std::string_view name);
std::string fourcc_text(std::uint32_t fourcc);

/// Bytes of one row without padding.
std::size_t row_bytes(const PixelFormat& format, int width);

/// @param stride bytes from row to row, at least row_bytes()
/// @param bytes of the picture; the last row needs no padding
/// @returns grey levels, rows from the top, at most format.white: bits beyond it are masked
/// @throws std::invalid_argument: sides or stride that do not fit; std::length_error: fewer bytes than the
/// rows
std::vector<std::uint16_t> grey_levels(const PixelFormat& format, int width, int height, std::size_t stride,
                                       std::span<const std::byte> bytes);

}  // namespace firn::camera
