#include "core/grid/png.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>

namespace firn {
namespace {

constexpr std::array<unsigned char, 8> kMagic = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::array<unsigned char, 8> kFirst = {0, 0, 0, 13, 'I', 'H', 'D', 'R'};  // a chunk: length, name
constexpr std::uint32_t kMaxRows = 1'000'000;                                       // libpng's own limit

// libpng leaves by a jump on an error. No object with a destructor lives between the jump and its target.
struct Told {
  std::array<char, 200> what{};
};
void on_error(png_structp png, png_const_charp what) {
  auto& told = *static_cast<Told*>(png_get_error_ptr(png));
  std::strncpy(told.what.data(), what, told.what.size() - 1);
  std::longjmp(png_jmpbuf(png), 1);
}
void on_warning(png_structp, png_const_charp) {}

struct Reader {
  Told told;
  std::span<const std::byte> left;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &told, on_error, on_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
};
void take(png_structp png, png_bytep to, std::size_t bytes) {
  auto& left = *static_cast<std::span<const std::byte>*>(png_get_io_ptr(png));
  if (bytes > left.size()) png_error(png, "ends too early");
  std::memcpy(to, left.data(), bytes);
  left = left.subspan(bytes);
}

struct Writer {
  Told told;
  std::vector<std::byte> out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &told, on_error, on_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  ~Writer() { png_destroy_write_struct(&png, &info); }
};
void give(png_structp png, png_bytep from, std::size_t bytes) {
  auto& out = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* first = reinterpret_cast<const std::byte*>(from);
  out.insert(out.end(), first, first + bytes);
}

std::uint32_t big_endian(std::span<const std::byte> b, std::size_t at) {
  return std::uint32_t(b[at]) << 24 | std::uint32_t(b[at + 1]) << 16 | std::uint32_t(b[at + 2]) << 8 |
         std::uint32_t(b[at + 3]);
}

}  // namespace

PngHeader png_header(std::span<const std::byte> png) {
  const auto same = [](unsigned char m, std::byte b) { return std::byte{m} == b; };
  if (png.size() < 33 || !std::equal(kMagic.begin(), kMagic.end(), png.begin(), same) ||
      !std::equal(kFirst.begin(), kFirst.end(), png.begin() + kMagic.size(), same))
    throw PngError("is not a PNG file");
  return {big_endian(png, 16), big_endian(png, 20), int(png[25])};
}

GreyPicture read_grey_png(std::span<const std::byte> png) {
  const PngHeader header = png_header(png);
  if (header.colour != PNG_COLOR_TYPE_GRAY) throw PngError("is no grey picture");
  if (header.width == 0 || header.height == 0) throw PngError("has no pixels");
  if (header.height > kMaxRows) throw PngError("has more than 1,000,000 rows");
  if (std::uint64_t(header.width) * header.height > 1u << 28) throw PngError("has more than 2^28 pixels");
  const std::size_t width = header.width, height = header.height;
  std::vector<std::uint8_t> bytes(2 * width * height);
  std::vector<png_bytep> rows(height);
  for (std::size_t y = 0; y < height; ++y) rows[y] = bytes.data() + 2 * width * y;
  Reader r;
  r.left = png;
  if (!r.info) throw PngError("cannot be decoded");
  if (setjmp(png_jmpbuf(r.png))) throw PngError(std::string("is damaged: ") + r.told.what.data());
  png_set_read_fn(r.png, &r.left, take);
  png_read_info(r.png, r.info);
  png_set_expand_gray_1_2_4_to_8(r.png);
  png_set_interlace_handling(r.png);
  png_read_update_info(r.png, r.info);
  png_read_image(r.png, rows.data());
  png_read_end(r.png, nullptr);
  const bool wide = png_get_bit_depth(r.png, r.info) == 16;
  GreyPicture picture{int(width), int(height), wide ? 65535.0 : 255.0, std::vector<double>(width * height)};
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      picture.pixels[y * width + x] = wide ? rows[y][2 * x] << 8 | rows[y][2 * x + 1] : rows[y][x];
  return picture;
}

std::vector<std::byte> write_png(int width, int height, int channels, std::span<const std::uint8_t> pixels) {
  const std::size_t stride = std::size_t(width) * std::size_t(channels);
  if (width < 1 || height < 1 || pixels.size() != stride * std::size_t(height))
    throw PngError("width, height and pixels disagree");
  Writer w;
  if (!w.info) throw PngError("cannot be encoded");
  if (setjmp(png_jmpbuf(w.png))) throw PngError(std::string("cannot be encoded: ") + w.told.what.data());
  png_set_write_fn(w.png, &w.out, give, nullptr);
  png_set_IHDR(w.png, w.info, png_uint_32(width), png_uint_32(height), 8,
               channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(w.png, w.info);
  for (std::size_t y = 0; y < std::size_t(height); ++y) png_write_row(w.png, pixels.data() + y * stride);
  png_write_end(w.png, nullptr);
  return std::move(w.out);
}

std::vector<std::byte> write_grey_png(int width, int height, int white,
                                      std::span<const std::uint16_t> pixels) {
  if (width < 1 || height < 1 || pixels.size() != std::size_t(width) * std::size_t(height))
    throw PngError("width, height and pixels disagree");
  const bool wide = white > 255;
  const std::size_t stride = std::size_t(width) * (wide ? 2 : 1);
  std::vector<std::uint8_t> row(stride);
  Writer w;
  if (!w.info) throw PngError("cannot be encoded");
  if (setjmp(png_jmpbuf(w.png))) throw PngError(std::string("cannot be encoded: ") + w.told.what.data());
  png_set_write_fn(w.png, &w.out, give, nullptr);
  png_set_compression_level(w.png, 1);
  png_set_filter(w.png, 0, PNG_FILTER_UP);
  png_set_IHDR(w.png, w.info, png_uint_32(width), png_uint_32(height), wide ? 16 : 8, PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(w.png, w.info);
  for (std::size_t y = 0; y < std::size_t(height); ++y) {
    const auto from = pixels.subspan(y * std::size_t(width), std::size_t(width));
    for (std::size_t x = 0; x < from.size(); ++x) {
      if (wide) row[2 * x] = std::uint8_t(from[x] >> 8);
      row[wide ? 2 * x + 1 : x] = std::uint8_t(from[x]);
    }
    png_write_row(w.png, row.data());
  }
  png_write_end(w.png, nullptr);
  return std::move(w.out);
}

}  // namespace firn
