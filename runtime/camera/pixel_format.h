// Converts the pixels of grey V4L2 formats, the luminance of YUYV, and pictures packed as JPEG (MJPG), to
// grey levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace firn::camera {

/// One pixel format. kWord: 16 bits, low byte first, of which the low ones count. kJpeg: a JPEG file a frame.
struct PixelFormat {
  enum class Layout : std::uint8_t { kByte, kWord, kYuyv, kJpeg };
  std::string_view name;     ///< as in a port's address: "Y12"
  std::uint32_t fourcc = 0;  ///< V4L2_PIX_FMT_…
  Layout layout = Layout::kByte;
  int white = 255;
};

/// GREY, Y10, Y12, Y16, YUYV and MJPG, the deepest first, and MJPG, which has lost detail, last.
std::span<const PixelFormat> pixel_formats();
const PixelFormat* pixel_format(std::uint32_t fourcc);  ///< nullptr: none of them
const PixelFormat* pixel_format(std::string_view name);
std::string fourcc_text(std::uint32_t fourcc);

/// Bytes of one row without padding; 0 of kJpeg.
std::size_t row_bytes(const PixelFormat& format, int width);

/// Decodes a JPEG file as grey levels of 8 bits.
/// @returns width * height levels, rows from the top
/// @throws std::length_error: damaged, or a picture of another size
using JpegDecoder =
    std::function<std::vector<std::uint16_t>(std::span<const std::byte> file, int width, int height)>;

/// @pre the format is not kJpeg
/// @param stride bytes from row to row, at least row_bytes()
/// @param bytes of the picture; the last row needs no padding
/// @returns grey levels, rows from the top, at most format.white: bits beyond it are masked
/// @throws std::invalid_argument: sides or stride that do not fit; std::length_error: fewer bytes than the
/// rows
std::vector<std::uint16_t> grey_levels(const PixelFormat& format, int width, int height, std::size_t stride,
                                       std::span<const std::byte> bytes);

}  // namespace firn::camera
