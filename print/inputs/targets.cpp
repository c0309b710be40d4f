#include "print/inputs/targets.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "config/error.h"
#include "config/nozzles.h"
#include "core/grid/npy.h"
#include "core/grid/png.h"
#include "core/options/for_people.h"
#include "files/digest.h"
#include "files/usage_error.h"
#include "print/inputs/geometry_input.h"
#include "print/inputs/python_input.h"
#include "procs/controller/node.h"

namespace firn {
namespace {

constexpr std::size_t kMaxPngBytes = 64u << 20;
constexpr double kMinCovered = 0.5 - 1e-9;  // of a cell, by pixels of the part
constexpr double kAspect = 0.005;           // of a depth that is given beside the width

// An image as it was named: file and configuration key.
struct ImageName {
  const std::string& file;
  const std::string& key;
};

[[noreturn]] void refuse_image(const ImageName& name, const std::string& problem) {
  throw ConfigError(name.file, 0, name.key, name.key + ": " + problem);
}

// Colours have no height of their own, and lossy formats blur the edge of a part: the user chooses.
std::string way_to_grey(const ImageName& name) {
  return "convert it, e.g. with ImageMagick: convert " + name.file +
         " -background white -alpha remove -colorspace Gray -define png:color-type=0 grey.png";
}

const char* colour_type(int type) {
  return type == 2   ? "colours"
         : type == 3 ? "a palette"
         : type == 4 ? "grey with alpha"
                     : "colours with alpha";
}

/// Names other formats, of which a user may think that they serve.
void check_is_png(std::span<const std::byte> bytes, const ImageName& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()),
                              std::min<std::size_t>(bytes.size(), 16));
  using namespace std::string_view_literals;
  static constexpr std::pair<std::string_view, const char*> kOthers[] = {
      {"\xFF\xD8\xFF"sv, "JPEG"}, {"II*\0"sv, "TIFF"}, {"MM\0*"sv, "TIFF"}, {"BM"sv, "BMP"},
      {"GIF8"sv, "GIF"},          {"RIFF"sv, "WebP"},  {"P5"sv, "PGM"},     {"P6"sv, "PPM"}};
  for (const auto& [mark, format] : kOthers)
    if (text.starts_with(mark))
      refuse_image(name,
                   std::string("is a ") + format + " picture; a grey PNG is needed: " + way_to_grey(name));
}

/// Checking the header first keeps a forged one from asking for gigabytes.
void check_png_header(std::span<const std::byte> png, const ImageName& name) {
  check_is_png(png, name);
  if (png.size() > kMaxPngBytes)
    refuse_image(name,
                 std::to_string(png.size()) + " bytes is above the limit of " + std::to_string(kMaxPngBytes));
  const auto [width, height, colour] = png_header(png);
  if (width < 1 || height < 1 || width > std::uint32_t(kMaxGridSide) || height > std::uint32_t(kMaxGridSide))
    refuse_image(name, std::to_string(width) + " x " + std::to_string(height) +
                           " pixels: each side must lie in [1, " + std::to_string(kMaxGridSide) + "]");
  if (colour != 0)
    refuse_image(name, "must be grey without alpha or palette (PNG colour type 0, this is " +
                           std::to_string(colour) + ": " + colour_type(colour) + "): " + way_to_grey(name));
}

/// Overlap of [a0, a1) with pixels along one axis: first pixel and weights that sum to a1 - a0.
struct Coverage {
  int first = 0;
  std::vector<double> weights;
};

// By area; beside the picture all is black.
double white_share(const GreyPicture& grey, const Coverage& x, const Coverage& y, double cell_px) {
  double sum = 0.0;
  for (std::size_t q = 0; q < y.weights.size(); ++q)
    for (std::size_t p = 0; p < x.weights.size(); ++p)
      sum += x.weights[p] * y.weights[q] * grey.at(x.first + int(p), y.first + int(q));
  return sum / grey.white / cell_px;
}

// The pixels of the part in one cell: their area, and the sum of their grey values by area.
struct PartOfCell {
  double area_px = 0.0, sum = 0.0;
};

PartOfCell part_of_cell(const GreyPicture& grey, const Coverage& x, const Coverage& y) {
  PartOfCell part;
  for (std::size_t q = 0; q < y.weights.size(); ++q)
    for (std::size_t p = 0; p < x.weights.size(); ++p) {
      const double w = x.weights[p] * y.weights[q], value = grey.at(x.first + int(p), y.first + int(q));
      if (value <= 0.0) continue;
      part.area_px += w;
      part.sum += w * value;
    }
  return part;
}

}  // namespace

Blob make_blob(std::string role, std::vector<std::byte> bytes) {
  std::string sha256 = sha256_hex(bytes);
  return {std::move(role), std::move(sha256), std::move(bytes)};
}

std::vector<std::byte> read_bytes(const std::filesystem::path& path, const std::string& key) {
  const std::string file = path.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) refuse_image({file, key}, "no such file");
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) refuse_image({file, key}, "cannot be read");
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

namespace {

GreyPicture read_picture(std::span<const std::byte> png, const ImageName& name) try {
  check_png_header(png, name);
  return read_grey_png(png);
} catch (const PngError& e) {
  refuse_image(name, e.what());
}

// Cells of one axis in pixels of a picture in the middle of the grid; negative and beyond: beside the
// picture.
std::vector<Coverage> placed(int cells, double pitch_mm, int pixels, double pixel_mm) {
  std::vector<Coverage> out(std::size_t(cells), Coverage{});
  const double offset = 0.5 * (pixels - cells * (pitch_mm / pixel_mm));
  for (int c = 0; c < cells; ++c) {
    const double a0 = offset + c * (pitch_mm / pixel_mm), a1 = offset + (c + 1) * (pitch_mm / pixel_mm);
    Coverage& cover = out[std::size_t(c)];
    cover.first = int(std::clamp(std::floor(a0), 0.0, double(pixels)));
    for (int p = cover.first; p < pixels && p < a1; ++p)
      cover.weights.push_back(std::max(0.0, std::min(a1, p + 1.0) - std::max(a0, double(p))));
  }
  return out;
}

// The picture may reach beyond the grid, the part may not: a row or column of pixels may miss it by a tenth.
// @param part_is true for the grey value of a pixel of the part
// @returns whether there is a part
template <class PartIs>
bool check_on_grid(const GreyPicture& grey, const GridSpec& g, const PixelSize& pixel, const ImageName& name,
                   PartIs part_is) {
  int low_x = grey.width, high_x = -1, low_y = grey.height, high_y = -1;
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x)
      if (part_is(grey.at(x, y))) {
        low_x = std::min(low_x, x);
        high_x = std::max(high_x, x);
        low_y = std::min(low_y, y);
        high_y = std::max(high_y, y);
      }
  const auto beyond = [&](int low, int high, int pixels, double pixel_mm, double grid_mm, const char* axis) {
    const double half_mm = std::max(0.5 * pixels - low, high + 1 - 0.5 * pixels) * pixel_mm - 0.1 * pixel_mm;
    if (half_mm <= 0.5 * grid_mm) return;
    refuse_image(name, "a picture of " + for_people(grey.width * pixel.x_mm) + " x " +
                           for_people(grey.height * pixel.y_mm) + " mm: along " + axis +
                           " the part reaches " + for_people(half_mm) +
                           " mm from the middle of the grid, which is " + for_people(0.5 * grid_mm) +
                           " mm to its edge");
  };
  if (high_x < 0) return false;
  beyond(low_x, high_x, grey.width, pixel.x_mm, g.nx * g.pitch_x_mm, "x");
  beyond(low_y, high_y, grey.height, pixel.y_mm, g.ny * g.pitch_y_mm, "y");
  return true;
}

// Columns and rows of a grid in pixels of a picture in its middle.
struct Placed {
  std::vector<Coverage> columns, rows;
  double cell_px;  // area of a cell
  Placed(const GreyPicture& grey, const GridSpec& g, const PixelSize& pixel)
      : columns(placed(g.nx, g.pitch_x_mm, grey.width, pixel.x_mm)),
        rows(placed(g.ny, g.pitch_y_mm, grey.height, pixel.y_mm)),
        cell_px(g.pitch_x_mm / pixel.x_mm * (g.pitch_y_mm / pixel.y_mm)) {
    std::ranges::reverse(rows);  // the picture's top row is at maximum y
  }
};

// The nozzle does not rise with the part: interlock 6 would stop the print in the middle of it.
void check_nozzle_gap(const Experiment& e, const Target& target) {
  const double clearance_mm = e.process.nozzle_clearance_mm, gap_mm = lowest_nozzle_mm(e);
  if (clearance_mm == 0.0) return;  // the interlock is off
  double highest_mm = 0.0;
  for (std::size_t c = 0; c < target.height.cells.size(); ++c)
    if (target.mask.cells[c]) highest_mm = std::max(highest_mm, target.height.cells[c]);
  if (highest_mm + clearance_mm > gap_mm)
    throw ConfigError(
        "part", 0, "process.nozzle_gap_mm",
        fmt::format("process.nozzle_gap_mm = {:g}: {}the part is {:g} mm high, and "
                    "process.nozzle_clearance_mm = {:g} mm is "
                    "needed above it: raise the gap, or print a lower part",
                    e.process.nozzle_gap_mm,
                    gap_mm < e.process.nozzle_gap_mm
                        ? fmt::format("with jet_b.offset_z_mm = {:g} the lower nozzle is at {:g} mm, ",
                                      e.jet_b.offset_z_mm, gap_mm)
                        : std::string(),
                    highest_mm, clearance_mm));
}

}  // namespace

Mask layer_from_png(std::span<const std::byte> png, const GridSpec& grid, const PixelSize& pixel,
                    const std::string& file) {
  const std::string key = "geometry.images";
  const ImageName name{file, key};
  check(grid);
  const GreyPicture grey = read_picture(png, name);
  check_on_grid(grey, grid, pixel, name, [&](double value) { return value >= 0.5 * grey.white; });
  const Placed at(grey, grid, pixel);
  Mask layer(grid);
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i)
      layer.at(i, j) =
          white_share(grey, at.columns[std::size_t(i)], at.rows[std::size_t(j)], at.cell_px) >= kMinCovered;
  return layer;
}

Target target_from_png(std::span<const std::byte> png, const GridSpec& grid, double white_mm,
                       const std::string& file, const std::optional<PixelSize>& given) {
  const std::string key = "part.image";
  const ImageName name{file, key};
  check(grid);
  const GreyPicture grey = read_picture(png, name);
  const PixelSize pixel = given.value_or(
      PixelSize{grid.nx * grid.pitch_x_mm / grey.width, grid.ny * grid.pitch_y_mm / grey.height});
  if (!check_on_grid(grey, grid, pixel, name, [](double value) { return value > 0.0; }))
    refuse_image(name, "is black everywhere: no part");
  const Placed at(grey, grid, pixel);
  Target target{HeightMap(grid), Mask(grid)};
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      const PartOfCell part = part_of_cell(grey, at.columns[std::size_t(i)], at.rows[std::size_t(j)]);
      if (part.area_px < kMinCovered * at.cell_px) continue;
      target.height.at(i, j) = part.sum / part.area_px / grey.white * white_mm;
      target.mask.at(i, j) = 1;
    }
  if (target.mask.count() == 0) refuse_image(name, "the part covers half of no cell");
  return target;
}

std::array<int, 2> picture_pixels(std::span<const std::byte> png, const std::string& name) {
  const GreyPicture grey = read_picture(png, {name, "part.image"});
  return {grey.width, grey.height};
}

PixelSize pixel_size(const PartConfig& part, std::span<const std::byte> png, const std::string& file) {
  const double width_mm = part.shape.width_mm, um_per_px = part.um_per_px, depth_mm = part.shape.depth_mm;
  const auto wrong = [&](const std::string& key, const std::string& problem) {
    throw ConfigError(file, 0, key, key + ": " + problem);
  };
  if (width_mm <= 0.0 && um_per_px <= 0.0)
    wrong("part.width_mm",
          "a picture needs a size: part.width_mm (its depth follows from its aspect), or "
          "part.um_per_px");
  if (width_mm > 0.0 && um_per_px > 0.0)
    wrong("part.um_per_px", "part.width_mm gives the picture's size already: only one of them");
  const std::string key = "part.image";
  const GreyPicture grey = read_picture(png, {file, key});
  const double mm = um_per_px > 0.0 ? um_per_px * 1e-3 : width_mm / grey.width;
  if (depth_mm > 0.0 && std::abs(depth_mm - grey.height * mm) > kAspect * depth_mm)
    wrong("part.depth_mm",
          for_people(depth_mm) + " mm is not the picture's depth: " + std::to_string(grey.height) +
              " rows of " + std::to_string(mm) + " mm are " + std::to_string(grey.height * mm) + " mm");
  return {mm, mm};
}

PixelSize layer_pixel_size(const PartConfig& part, std::span<const std::byte> png, const std::string& file) {
  const std::string key = "geometry.images";
  const ShapeSpec& s = part.shape;
  const bool by_width = s.kind == "cuboid" || s.kind == "wedge" || s.kind == "height_map";
  const double width_mm = s.kind == "mesh" ? 0.0 : by_width ? s.width_mm : s.diameter_mm;
  const GreyPicture grey = read_picture(png, {file, key});
  const double mm = part.um_per_px > 0.0 ? part.um_per_px * 1e-3 : width_mm / grey.width;
  if (!(mm > 0.0))
    throw ConfigError(file, 0, key,
                      key + ": its pictures need a size: the width of [part], or part.um_per_px");
  return {mm, mm};
}

Blobs make_target_inputs(const Experiment& experiment, const std::filesystem::path& folder,
                         const MeshInputs* meshes) {
  Blobs blobs;
  Target target;
  if (experiment.part.shape.kind == "height_map") {
    const std::filesystem::path path = folder / experiment.part.image;
    std::vector<std::byte> png = read_bytes(path, "part.image");
    const PixelSize pixel = pixel_size(experiment.part, png, path.string());
    target = target_from_png(png, experiment.grid, experiment.part.image_white_mm, path.string(), pixel);
    blobs.push_back(make_blob("image", std::move(png)));
  } else if (experiment.part.shape.kind == "mesh") {
    if (!meshes) throw UsageError("part.shape = \"mesh\": this program reads no meshes; firn print does");
    target = meshes->target(experiment, folder);
  } else {
    try {
      target = make_shape(experiment.part.shape, experiment.grid);
    } catch (const std::invalid_argument& e) {
      throw ConfigError("part", 0, "part.shape", e.what());
    }
  }
  check_nozzle_gap(experiment, target);
  blobs.insert(blobs.begin(),
               {make_blob("target", to_npy(target.height)), make_blob("mask", to_npy(target.mask))});
  const auto geometry = make_geometry(experiment, target.height, folder, meshes);
  if (geometry) blobs.push_back(make_blob("geometry", to_bytes(*geometry)));
  const auto shared = geometry ? std::make_shared<const Geometry>(*geometry) : nullptr;
  add_python_inputs(
      experiment, folder, target.mask,
      [&](const Blobs& files) {
        make_scheme(control_setup(experiment, target.height, target.mask, shared),
                    control_options(experiment), files);
      },
      blobs);
  return blobs;
}

void check_target_inputs(const Experiment& e, const Blobs& inputs) {
  check_nozzle_gap(e, {height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target"),
                       mask_from_npy(blob(inputs, "mask").bytes, e.grid, "mask")});
}

}  // namespace firn
