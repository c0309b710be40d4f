#include "print/inputs/targets.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "config/error.h"
#include "core/grid/npy.h"
#include "core/grid/png.h"
#include "files/digest.h"
#include "print/inputs/geometry_input.h"

namespace firn {
namespace {

constexpr std::size_t kMaxPngBytes = 64u << 20;

// An image as it was named: file and configuration key.
struct ImageName {
  const std::string& file;
  const std::string& key;
};

[[noreturn]] void refuse(const ImageName& name, const std::string& problem) {
  throw ConfigError(name.file, 0, name.key, name.key + ": " + problem);
}

/// Checking the header first keeps a forged one from asking for gigabytes.
void check_png_header(std::span<const std::byte> png, const ImageName& name) {
  if (png.size() > kMaxPngBytes)
    refuse(name, std::to_string(png.size()) + " bytes is above the limit of " + std::to_string(kMaxPngBytes));
  const auto [width, height, colour] = png_header(png);
  if (width < 1 || height < 1 || width > std::uint32_t(kMaxGridSide) || height > std::uint32_t(kMaxGridSide))
    refuse(name, std::to_string(width) + " x " + std::to_string(height) +
                     " pixels: each side must lie in [1, " + std::to_string(kMaxGridSide) + "]");
  if (colour != 0)
    refuse(name, "must be grey without alpha or palette (PNG colour type 0, this is " +
                     std::to_string(colour) + ")");
}

/// Overlap of [a0, a1) with pixels along one axis: first pixel and weights that sum to a1 - a0.
struct Coverage {
  int first = 0;
  std::vector<double> weights;
};

std::vector<Coverage> coverage(int cells, int pixels) {
  std::vector<Coverage> out(std::size_t(cells), Coverage{});
  for (int c = 0; c < cells; ++c) {
    const double a0 = double(c) * pixels / cells, a1 = double(c + 1) * pixels / cells;
    Coverage& cover = out[std::size_t(c)];
    cover.first = std::min(int(a0), pixels - 1);
    for (int p = cover.first; p < pixels && p < a1; ++p)
      cover.weights.push_back(std::min(a1, p + 1.0) - std::max(a0, double(p)));
  }
  return out;
}

double cell_average(const GreyPicture& grey, const Coverage& x, const Coverage& y) {
  double sum = 0.0, area = 0.0;
  for (std::size_t q = 0; q < y.weights.size(); ++q)
    for (std::size_t p = 0; p < x.weights.size(); ++p) {
      const double w = x.weights[p] * y.weights[q];
      sum += w * grey.at(x.first + int(p), y.first + int(q));
      area += w;
    }
  return sum / area;
}

Blob make_blob(std::string role, std::vector<std::byte> bytes) {
  std::string name = sha256_hex(bytes);
  return {std::move(role), std::move(name), std::move(bytes)};
}

}  // namespace

std::vector<std::byte> read_bytes(const std::filesystem::path& path, const std::string& key) {
  const std::string file = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) refuse({file, key}, "no such file");
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) refuse({file, key}, "cannot be read");
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

Grid<double> grey_from_png(std::span<const std::byte> png, const GridSpec& grid, const std::string& file,
                           const std::string& key) {
  const ImageName name{file, key};
  check(grid);
  const GreyPicture grey = [&] {
    try {
      check_png_header(png, name);
      return read_grey_png(png);
    } catch (const PngError& e) {
      refuse(name, e.what());
    }
  }();
  Grid<double> out(grid);
  const std::vector<Coverage> columns = coverage(grid.nx, grey.width), rows = coverage(grid.ny, grey.height);
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i)
      out.at(i, j) =
          cell_average(grey, columns[std::size_t(i)], rows[std::size_t(grid.ny - 1 - j)]) / grey.white;
  return out;
}

Target target_from_png(std::span<const std::byte> png, const GridSpec& grid, double white_mm,
                       const std::string& name) {
  const std::string key = "part.image";
  const Grid<double> grey = grey_from_png(png, grid, name, key);
  Target target{HeightMap(grid), Mask(grid)};
  for (std::size_t c = 0; c < grey.size(); ++c) {
    if (grey.cells[c] <= 0.0) continue;
    target.height.cells[c] = grey.cells[c] * white_mm;
    target.mask.cells[c] = 1;
  }
  if (target.mask.count() == 0) refuse({name, key}, "is black everywhere: no part");
  return target;
}

Blobs make_target_inputs(const Experiment& experiment, const std::filesystem::path& folder) {
  Blobs blobs;
  Target target;
  if (experiment.part.shape.kind == "height_map") {
    const std::filesystem::path path = folder / experiment.part.image;
    std::vector<std::byte> png = read_bytes(path, "part.image");
    target = target_from_png(png, experiment.grid, experiment.part.image_white_mm, path.string());
    blobs.push_back(make_blob("image", std::move(png)));
  } else {
    try {
      target = make_shape(experiment.part.shape, experiment.grid);
    } catch (const std::invalid_argument& e) {
      throw ConfigError("part", 0, "part.shape", e.what());
    }
  }
  blobs.insert(blobs.begin(),
               {make_blob("target", to_npy(target.height)), make_blob("mask", to_npy(target.mask))});
  if (const auto geometry = make_geometry(experiment, target.height, folder))
    blobs.push_back(make_blob("geometry", to_bytes(*geometry)));
  return blobs;
}

}  // namespace firn
