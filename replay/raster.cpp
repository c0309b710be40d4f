#include "replay/raster.h"

#include <algorithm>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace firn::replay {
namespace {

std::string base64(const std::vector<uchar>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string s;
  for (std::size_t n = 0; n < bytes.size(); n += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - n);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? bytes[n + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) s += k <= left ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return s;
}

}  // namespace

std::string svg_image(const Raster& raster, double x, double y, double width, double height) {
  cv::Mat4b bgra(raster.height, raster.width);
  for (int row = 0; row < raster.height; ++row)
    for (int column = 0; column < raster.width; ++column) {
      const Rgba& p = raster.pixels[std::size_t(row) * std::size_t(raster.width) + std::size_t(column)];
      bgra(row, column) = {p[2], p[1], p[0], p[3]};
    }
  std::vector<uchar> png;
  cv::imencode(".png", bgra, png);
  char head[200];
  std::snprintf(head, sizeof head,
                "<image x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" preserveAspectRatio=\"none\" class=\"cells\" href=\"data:image/png;base64,", x, y,
                width, height);
  return head + base64(png) + "\"/>\n";
}

}  // namespace firn::replay
