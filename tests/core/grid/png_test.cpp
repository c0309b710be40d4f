// PNG: pixels come back as they were written, and a file that is not whole is refused.
#include "core/grid/png.h"

#include <png.h>

#include <catch2/catch.hpp>
#include <vector>

#include "core/grid/random.h"

using namespace firn;

namespace {

std::vector<std::byte> noisy_png(int width, int height, int white, std::vector<std::uint16_t>& pixels) {
  RandomStream random(std::uint64_t(width * 1000 + height), Purpose::kTest);
  pixels.resize(std::size_t(width) * std::size_t(height));
  for (std::uint16_t& p : pixels) p = std::uint16_t(random.below(std::uint32_t(white) + 1));
  return write_grey_png(width, height, white, pixels);
}

}  // namespace

TEST_CASE("Grey pixels of 8 and of 16 bits come back as they were written, for any size") {
  for (const int white : {255, 65535})
    for (const auto [width, height] : {std::pair{1, 1}, {1, 7}, {7, 1}, {13, 5}, {64, 33}}) {
      CAPTURE(white, width, height);
      std::vector<std::uint16_t> pixels;
      const GreyPicture read = read_grey_png(noisy_png(width, height, white, pixels));
      CHECK(read.width == width);
      CHECK(read.height == height);
      CHECK(read.white == white);
      CHECK(read.pixels == std::vector<double>(pixels.begin(), pixels.end()));
    }
}

TEST_CASE("A PNG that is cut anywhere is refused, behind its last pixel too") {
  std::vector<std::uint16_t> pixels;
  const std::vector<std::byte> whole = noisy_png(9, 6, 255, pixels);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    CAPTURE(n, whole.size());
    CHECK_THROWS_AS(read_grey_png(std::span(whole).first(n)), PngError);
  }
}

TEST_CASE("A PNG with a wrong bit in its pixels or their checksum is refused") {
  std::vector<std::uint16_t> pixels;
  const std::vector<std::byte> whole = noisy_png(9, 6, 255, pixels);
  constexpr std::size_t kPixels = 33 + 8, kEnd = 12;  // behind the header and the chunk's head, end chunk
  for (std::size_t n = kPixels; n + kEnd < whole.size(); ++n) {
    CAPTURE(n);
    std::vector<std::byte> damaged = whole;
    damaged[n] ^= std::byte{0x10};
    CHECK_THROWS_AS(read_grey_png(damaged), PngError);
  }
}

TEST_CASE("Pictures in colour have the pixels that libpng's own reader finds") {
  for (const int channels : {3, 4}) {
    CAPTURE(channels);
    constexpr int kWidth = 11, kHeight = 4;
    RandomStream random(7, Purpose::kTest);
    std::vector<std::uint8_t> pixels(std::size_t(kWidth * kHeight * channels));
    for (std::uint8_t& p : pixels) p = std::uint8_t(random.below(256));
    const std::vector<std::byte> file = write_png(kWidth, kHeight, channels, pixels);
    const PngHeader header = png_header(file);
    CHECK(header.width == kWidth);
    CHECK(header.height == kHeight);
    CHECK_THROWS_WITH(read_grey_png(file), "is no grey picture");
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_memory(&image, file.data(), file.size()));
    image.format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB;
    std::vector<std::uint8_t> read(PNG_IMAGE_SIZE(image));
    REQUIRE(png_image_finish_read(&image, nullptr, read.data(), 0, nullptr));
    CHECK(read == pixels);
  }
}

TEST_CASE("Pixels that are not as many as width and height say are refused by both writers") {
  const std::vector<std::uint16_t> grey(11);
  const std::vector<std::uint8_t> colour(35);
  CHECK_THROWS_AS(write_grey_png(3, 4, 255, grey), PngError);
  CHECK_THROWS_AS(write_grey_png(0, 4, 255, {}), PngError);
  CHECK_THROWS_AS(write_png(3, 4, 3, colour), PngError);
  CHECK_THROWS_AS(write_png(4, 0, 3, {}), PngError);
}
