#include "report/draw/heat_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "report/draw/svg.h"

namespace firn::report {
namespace {

constexpr double kSide = 300;  // pixels of the longer side of a map

constexpr double kErrorColours[3][3] = {
#include "report/draw/error_colours.inc"
};

cv::Vec3b diverging(double share) {
  const auto mix = [&](int colour) {
    const double t = std::abs(2 * share - 1), middle = kErrorColours[1][colour];
    return cv::saturate_cast<uchar>(middle + t * (kErrorColours[share < 0.5 ? 0 : 2][colour] - middle));
  };
  return {mix(2), mix(1), mix(0)};  // B, G, R
}

// 256 colours, lowest first, as B, G, R.
cv::Mat3b palette(ColorMap colors) {
  cv::Mat3b table(1, 256);
  if (colors == ColorMap::kSequential) {
    cv::Mat1b ramp(1, 256);
    for (int n = 0; n < 256; ++n) ramp(0, n) = uchar(n);
    cv::Mat colored;
    cv::applyColorMap(ramp, colored, cv::COLORMAP_CIVIDIS);
    return colored;
  }
  for (int n = 0; n < 256; ++n) table(0, n) = diverging(n / 255.0);
  return table;
}

std::string image(const cv::Mat3b& colors, double x, double y, double width, double height) {
  Raster raster(colors.cols, colors.rows);
  for (int row = 0; row < colors.rows; ++row)
    for (int column = 0; column < colors.cols; ++column) {
      const cv::Vec3b& c = colors(row, column);
      raster.at(column, row) = {c[2], c[1], c[0], 255};
    }
  return svg_image(raster, x, y, width, height);
}

// The edges between cells of the part and others, as runs along x and along y.
std::string outline(const Mask& part, const Frame& f) {
  const int nx = part.spec.nx, ny = part.spec.ny;
  const double cell_x = (f.right - f.left) / nx, cell_y = (f.bottom - f.top) / ny;
  const auto in = [&](int i, int j) { return i >= 0 && j >= 0 && i < nx && j < ny && part.at(i, j) != 0; };
  std::string d;
  char text[80];
  for (int j = 0; j <= ny; ++j)
    for (int i = 0, from = 0; i < nx; i = std::max(i + 1, from)) {
      for (from = i; from < nx && in(from, j) != in(from, j - 1);) ++from;
      if (from == i) continue;
      std::snprintf(text, sizeof text, "M%.2f %.2fh%.2f", f.left + i * cell_x, f.bottom - j * cell_y,
                    (from - i) * cell_x);
      d += text;
    }
  for (int i = 0; i <= nx; ++i)
    for (int j = 0, from = 0; j < ny; j = std::max(j + 1, from)) {
      for (from = j; from < ny && in(i, from) != in(i - 1, from);) ++from;
      if (from == j) continue;
      std::snprintf(text, sizeof text, "M%.2f %.2fv%.2f", f.left + i * cell_x, f.bottom - j * cell_y,
                    -(from - j) * cell_y);
      d += text;
    }
  return "<path class=\"outline\" d=\"" + d + "\"/>\n";
}

}  // namespace

Raster colour_cells(const HeightMap& height, const HeatScale& scale) {
  const GridSpec& g = height.spec;
  const cv::Mat3b colors = palette(scale.colors);
  Raster pixels(g.nx, g.ny);
  for (int j = 0; j < g.ny; ++j)
    for (int i = 0; i < g.nx; ++i) {
      const double um = height.at(i, j) * 1e3;
      if (!std::isfinite(um)) continue;
      const double share = std::clamp((um - scale.low_um) / (scale.high_um - scale.low_um), 0.0, 1.0);
      const cv::Vec3b c = colors(0, int(std::lround(share * 255)));
      pixels.at(i, g.ny - 1 - j) = {c[2], c[1], c[0], 255};
    }
  return pixels;
}

std::string heat_map(const HeightMap& height, const HeatScale& scale, const std::string& title,
                     const Mask* part) {
  const GridSpec& g = height.spec;
  const Raster pixels = colour_cells(height, scale);
  const double width_mm = g.nx * g.pitch_x_mm, height_mm = g.ny * g.pitch_y_mm,
               longer = std::max(width_mm, height_mm);
  Frame f;
  f.left = 46;
  f.top = 8;
  f.right = f.left + kSide * width_mm / longer;
  f.bottom = f.top + kSide * height_mm / longer;
  // Axes over the cells' outer edges; ticks at round values inside.
  const double x0 = g.x_mm(0) - g.pitch_x_mm / 2, y0 = g.y_mm(0) - g.pitch_y_mm / 2;
  std::string s = svg_open(f.right + 12, f.bottom + 44, title) +
                  svg_image(pixels, f.left, f.top, f.right - f.left, f.bottom - f.top);
  if (part) s += outline(*part, f);
  char line[160];
  const Axis x_axis(x0, x0 + width_mm, 0, 1, 5), y_axis(y0, y0 + height_mm, 0, 1, 5);
  for (const Axis::Tick& t : x_axis.ticks()) {
    const double at = f.left + (t.value - x0) / width_mm * (f.right - f.left);
    if (at < f.left - 0.5 || at > f.right + 0.5) continue;
    std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fv4\"/>", at, f.bottom);
    s += line + svg_text(at, f.bottom + 17, "middle", "tick", t.text);
  }
  for (const Axis::Tick& t : y_axis.ticks()) {
    const double at = f.bottom - (t.value - y0) / height_mm * (f.bottom - f.top);
    if (at < f.top - 0.5 || at > f.bottom + 0.5) continue;
    std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fh-4\"/>", f.left, at);
    s += line + svg_text(f.left - 7, at + 4, "end", "tick", t.text);
  }
  std::snprintf(line, sizeof line, "<g transform=\"translate(13 %.1f) rotate(-90)\">",
                (f.top + f.bottom) / 2);
  return s + svg_text((f.left + f.right) / 2, f.bottom + 36, "middle", "name", "x [mm]") + line +
         svg_text(0, 0, "middle", "name", "y [mm]") + "</g>\n</svg>\n";
}

std::string color_bar(const HeatScale& scale, const std::string& name) {
  constexpr double kLeft = 12, kTop = 4, kWidth = 420, kHeight = 14;
  std::string s = svg_open(kLeft * 2 + kWidth + 20, 56, name) +
                  image(palette(scale.colors), kLeft, kTop, kWidth, kHeight);
  char line[160];
  constexpr double kMmPerUm = 1e-3;
  const double unit = scale.in_mm ? kMmPerUm : 1.0, low = scale.low_um * unit, high = scale.high_um * unit;
  const Axis axis(low, high, 0, 1, 6);
  for (const Axis::Tick& t : axis.ticks()) {
    const double at = kLeft + (t.value - low) / (high - low) * kWidth;
    if (at < kLeft - 0.5 || at > kLeft + kWidth + 0.5) continue;
    std::snprintf(line, sizeof line, "<path class=\"axis\" d=\"M%.1f %.1fv4\"/>", at, kTop + kHeight);
    s += line + svg_text(at, kTop + kHeight + 17, "middle", "tick", t.text);
  }
  return s + svg_text(kLeft + kWidth / 2, kTop + kHeight + 34, "middle", "name", name) + "</svg>\n";
}

}  // namespace firn::report
