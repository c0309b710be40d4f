#include "runtime/camera/pixel_format.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace firn::camera {
namespace {

using Layout = PixelFormat::Layout;

constexpr std::array kFormats{PixelFormat{"Y16", V4L2_PIX_FMT_Y16, Layout::kWord, 65535},
                              PixelFormat{"Y12", V4L2_PIX_FMT_Y12, Layout::kWord, 4095},
                              PixelFormat{"Y10", V4L2_PIX_FMT_Y10, Layout::kWord, 1023},
                              PixelFormat{"GREY", V4L2_PIX_FMT_GREY, Layout::kByte, 255},
                              PixelFormat{"YUYV", V4L2_PIX_FMT_YUYV, Layout::kYuyv, 255},
                              PixelFormat{"MJPG", V4L2_PIX_FMT_MJPEG, Layout::kJpeg, 255}};

template <class Key>
const PixelFormat* found(Key key, Key PixelFormat::*member) {
  const auto at = std::ranges::find(kFormats, key, member);
  return at == kFormats.end() ? nullptr : &*at;
}

}  // namespace

std::span<const PixelFormat> pixel_formats() { return kFormats; }
const PixelFormat* pixel_format(std::uint32_t fourcc) { return found(fourcc, &PixelFormat::fourcc); }
const PixelFormat* pixel_format(std::string_view name) { return found(name, &PixelFormat::name); }

std::string fourcc_text(std::uint32_t fourcc) {
  std::string text;
  for (int n = 0; n < 4; ++n) {
    const char c = char(fourcc >> 8 * n & 0x7F);
    text.push_back(c > 0x20 && c < 0x7F ? c : '_');
  }
  while (text.size() > 1 && text.back() == '_') text.pop_back();
  return text;
}

std::size_t row_bytes(const PixelFormat& format, int width) {
  const auto w = std::size_t(width);
  if (format.layout == Layout::kJpeg) return 0;
  if (format.layout == Layout::kByte) return w;
  return format.layout == Layout::kWord ? 2 * w : 4 * ((w + 1) / 2);
}

std::vector<std::uint16_t> grey_levels(const PixelFormat& format, int width, int height, std::size_t stride,
                                       std::span<const std::byte> bytes) {
  if (width < 1 || height < 1) throw std::invalid_argument("a picture without pixels");
  const std::size_t row = row_bytes(format, width), rows = std::size_t(height);
  if (stride < row)
    throw std::invalid_argument("a stride of " + std::to_string(stride) + " bytes is shorter than a row of " +
                                std::to_string(row));
  if (const std::size_t needed = stride * (rows - 1) + row; bytes.size() < needed)
    throw std::length_error("a frame of " + std::to_string(bytes.size()) +
                            " bytes is shorter than its rows of " + std::to_string(needed));
  std::vector<std::uint16_t> levels(std::size_t(width) * rows);
  for (std::size_t y = 0; y < rows; ++y) {
    const std::byte* from = bytes.data() + y * stride;
    std::uint16_t* to = levels.data() + y * std::size_t(width);
    for (std::size_t x = 0; x < std::size_t(width); ++x) {
      if (format.layout == Layout::kWord)
        to[x] =
            std::uint16_t((unsigned(from[2 * x]) | unsigned(from[2 * x + 1]) << 8) & unsigned(format.white));
      else
        to[x] = std::uint16_t(from[format.layout == Layout::kYuyv ? 2 * x : x]);
    }
  }
  return levels;
}

}  // namespace firn::camera
