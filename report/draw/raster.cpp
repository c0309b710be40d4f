#include "report/draw/raster.h"

#include <algorithm>
#include <cstdio>
#include <span>

#include "core/grid/png.h"

namespace firn::report {
namespace {

std::string base64(std::span<const std::byte> bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string s;
  for (std::size_t n = 0; n < bytes.size(); n += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - n);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? std::uint32_t(bytes[n + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) s += k <= left ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return s;
}

}  // namespace

std::vector<std::byte> png_of(const Raster& raster) {
  static_assert(sizeof(Rgba) == 4);
  return write_png(raster.width, raster.height, 4, {raster.pixels.data()->data(), 4 * raster.pixels.size()});
}

std::string svg_image(const Raster& raster, double x, double y, double width, double height) {
  char head[200];
  std::snprintf(head, sizeof head,
                "<image x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" preserveAspectRatio=\"none\" "
                "class=\"cells\" href=\"data:image/png;base64,",
                x, y, width, height);
  return head + base64(png_of(raster)) + "\"/>\n";
}

}  // namespace firn::report
