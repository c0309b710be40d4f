// Raster holds pixels inside a drawing: one embedded PNG.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace firn::report {

using Rgba = std::array<std::uint8_t, 4>;

/// Holds pixels in rows from the top; starts transparent.
struct Raster {
  int width, height;
  std::vector<Rgba> pixels;
  Raster(int w, int h) : width(w), height(h), pixels(std::size_t(w) * std::size_t(h), Rgba{0, 0, 0, 0}) {}
  Rgba& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

/// Returns the pixels as the bytes of a PNG.
std::vector<std::byte> png_of(const Raster& raster);

/// Returns an <image> over the given rectangle of the drawing, its pixels as squares.
std::string svg_image(const Raster& raster, double x, double y, double width, double height);

}  // namespace firn::report
