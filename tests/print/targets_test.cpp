#include <catch2/catch.hpp>

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "config/error.h"
#include "core/grid/npy.h"
#include "core/grid/png.h"
#include "core/grid/random.h"
#include "files/digest.h"
#include "print/inputs/targets.h"
#include "print/labs/full_product.h"

using namespace firn;

namespace {

std::vector<std::byte> png(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  cv::imencode(".png", image, bytes);
  const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
  return {begin, begin + bytes.size()};
}

GridSpec grid(int nx, int ny) { return {nx, ny, 0.25, 0.25, 0.0, 0.0}; }

}  // namespace

TEST_CASE("SHA-256 of the empty and the standard's example message are those of FIPS 180-4") {
  CHECK(sha256_hex({}) == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const char* abc = "abc";
  CHECK(sha256_hex({reinterpret_cast<const std::byte*>(abc), 3}) ==
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST_CASE(
    "An 8 and a 16 bit picture of the grid's size give every cell its own pixel, top row at largest y") {
  RandomStream random(1, Purpose::kTest);
  for (const int depth : {CV_8U, CV_16U}) {
    cv::Mat image(3, 4, depth);
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) {
        if (depth == CV_8U)
          image.at<std::uint8_t>(row, col) = std::uint8_t(random.below(256));
        else
          image.at<std::uint16_t>(row, col) = std::uint16_t(random.below(65536));
      }
    if (depth == CV_8U)
      image.at<std::uint8_t>(2, 0) = 0;
    else
      image.at<std::uint16_t>(2, 0) = 0;
    const Target t = target_from_png(png(image), grid(4, 3), 0.5, "x.png");
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 4; ++col) {
        const double grey = depth == CV_8U ? image.at<std::uint8_t>(row, col) / 255.0
                                           : image.at<std::uint16_t>(row, col) / 65535.0;
        CHECK(t.height.at(col, 2 - row) == Approx(0.5 * grey).margin(1e-15));
        CHECK(int(t.mask.at(col, 2 - row)) == int(grey > 0.0));
      }
    CHECK(int(t.mask.at(0, 0)) == 0);
  }
}

TEST_CASE("A picture of another size keeps its volume: cells are averages over their area") {
  RandomStream random(2, Purpose::kTest);
  for (int n = 0; n < 30; ++n) {
    const int rows = 1 + int(random.below(90)), cols = 1 + int(random.below(90));
    cv::Mat image(rows, cols, CV_8U);
    double sum = 0.0;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < cols; ++c)
        sum += image.at<std::uint8_t>(r, c) = std::uint8_t(1 + random.below(255));
    const GridSpec spec = grid(1 + int(random.below(50)), 1 + int(random.below(50)));
    const Target t = target_from_png(png(image), spec, 1.0, "x.png");
    double cells = 0.0;
    for (double h : t.height.cells) cells += h;
    CHECK(cells / double(spec.size()) == Approx(sum / 255.0 / (rows * cols)).epsilon(1e-12));
  }
}

TEST_CASE("A uniformly white picture of any size is a flat block of the white height") {
  const Target t = target_from_png(png(cv::Mat(17, 5, CV_16U, cv::Scalar(65535))), grid(12, 7), 0.4, "x.png");
  for (double h : t.height.cells) CHECK(h == Approx(0.4).epsilon(1e-14));
  CHECK(t.mask.count() == 84);
}

TEST_CASE("A picture keeps its size and its aspect: 12 x 8 mm with a round hole on a grid of any pitch") {
  // 240 x 160 pixels of 50 um, white but for a hole of 3 mm across at (3.5, 4) mm from the low corner.
  cv::Mat image(160, 240, CV_8U, cv::Scalar(200));
  for (int row = 0; row < 160; ++row)
    for (int col = 0; col < 240; ++col)
      if (std::hypot((col + 0.5) * 0.05 - 3.5, 8.0 - (row + 0.5) * 0.05 - 4.0) < 1.5)
        image.at<std::uint8_t>(row, col) = 0;
  for (const GridSpec spec : {GridSpec{60, 50, 0.263256, 0.263256, 1.0, -2.0},
                              GridSpec{50, 60, 0.25, 0.2, 0, 0}, GridSpec{130, 90, 0.1, 0.1, 0, 0}}) {
    const Target t = target_from_png(png(image), spec, 0.51, "x.png", PixelSize{0.05, 0.05});
    const double middle_x = 0.5 * (spec.x_mm(0) + spec.x_mm(spec.nx - 1)),
                 middle_y = 0.5 * (spec.y_mm(0) + spec.y_mm(spec.ny - 1));
    for (int j = 0; j < spec.ny; ++j)
      for (int i = 0; i < spec.nx; ++i) {
        const double x = spec.x_mm(i) - middle_x, y = spec.y_mm(j) - middle_y,
                     slack = 0.75 * std::max(spec.pitch_x_mm, spec.pitch_y_mm);
        const double to_edge = std::min(6.0 - std::abs(x), 4.0 - std::abs(y)),
                     to_hole = std::hypot(x + 2.5, y) - 1.5, inside = std::min(to_edge, to_hole);
        CAPTURE(x, y);
        if (inside > slack) CHECK(int(t.mask.at(i, j)) == 1);
        if (inside < -slack) CHECK(int(t.mask.at(i, j)) == 0);
        // A rim cell is as high as the part's pixels, not a fraction of that.
        CHECK(t.height.at(i, j) == Approx(t.mask.at(i, j) ? 0.4 : 0.0).margin(1e-12));
      }
    const double cell_mm2 = spec.pitch_x_mm * spec.pitch_y_mm;
    CHECK(double(t.mask.count()) * cell_mm2 == Approx(96.0 - CV_PI * 2.25).epsilon(0.02));
  }
}

TEST_CASE("A cell belongs to the part from half its area on, with the mean height of the part's pixels") {
  // Cells of 2 x 2 pixels, with 0 to 4 of them in the part.
  cv::Mat image = (cv::Mat_<std::uint8_t>(2, 10) << 0, 0, 9, 0, 9, 30, 9, 30, 9, 30,  //
                   0, 0, 0, 0, 0, 0, 0, 60, 60, 101);
  const Target t = target_from_png(png(image), grid(5, 1), 255.0, "x.png", PixelSize{0.125, 0.125});
  const double heights[] = {0.0, 0.0, 19.5, 33.0, 50.0};
  for (int i = 0; i < 5; ++i) {
    CHECK(int(t.mask.at(i, 0)) == int(i >= 2));
    CHECK(t.height.at(i, 0) == Approx(heights[i]).margin(1e-9));
  }
}

TEST_CASE("A picture needs one size that fits its aspect, and a part within the grid") {
  const auto bytes = png(cv::Mat(40, 60, CV_8U, cv::Scalar(7)));
  PartConfig part;
  CHECK_THROWS_WITH(pixel_size(part, bytes, "x.png"),
                    Catch::Contains("x.png: part.width_mm: a picture needs a size"));
  part.shape.width_mm = 12.0;
  CHECK(pixel_size(part, bytes, "x.png").x_mm == Approx(0.2));
  CHECK(pixel_size(part, bytes, "x.png").y_mm == Approx(0.2));
  part.um_per_px = 200.0;
  CHECK_THROWS_WITH(pixel_size(part, bytes, "x.png"),
                    Catch::Contains("part.um_per_px") && Catch::Contains("only one"));
  part.shape.width_mm = 0.0;
  CHECK(pixel_size(part, bytes, "x.png").x_mm == Approx(0.2));
  part.shape.depth_mm = 8.0;
  CHECK(pixel_size(part, bytes, "x.png").x_mm == Approx(0.2));
  part.shape.depth_mm = 9.0;
  CHECK_THROWS_WITH(pixel_size(part, bytes, "x.png"),
                    Catch::Contains("part.depth_mm") && Catch::Contains("8.0"));
  CHECK_THROWS_WITH(target_from_png(bytes, grid(40, 40), 0.4, "x.png", PixelSize{0.2, 0.2}),
                    Catch::Contains("along x the part reaches 5.98"));
  CHECK(target_from_png(bytes, grid(48, 40), 0.4, "x.png", PixelSize{0.2, 0.2}).mask.count() == 48 * 32);
}

TEST_CASE("A wrong picture is refused with its name and the reason") {
  const auto refused = [](std::vector<std::byte> bytes, const char* why) {
    CHECK_THROWS_WITH(target_from_png(bytes, grid(4, 4), 0.4, "x.png"),
                      Catch::StartsWith("x.png: part.image: ") && Catch::Contains(why));
  };
  refused({}, "not a PNG");
  refused(png(cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3))), "must be grey");
  refused(png(cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3))), "colours): convert it");
  refused(png(cv::Mat(4, 4, CV_8UC4, cv::Scalar(1, 2, 3, 4))), "must be grey");
  refused(png(cv::Mat(4, 4, CV_8U, cv::Scalar(0))), "black everywhere");
  refused(png(cv::Mat(1, 5000, CV_8U, cv::Scalar(9))), "each side");
  std::vector<std::byte> jpeg{std::byte{0xff}, std::byte{0xd8}};
  jpeg.resize(100);
  refused(jpeg, "not a PNG");
  jpeg[2] = std::byte{0xff};
  refused(jpeg, "is a JPEG picture; a grey PNG is needed: convert it, e.g. with ImageMagick: convert x.png ");
}

TEST_CASE("A picture whose header claims no pixels or too many rows is refused before memory is taken") {
  const auto refused = [](std::uint32_t width, std::uint32_t height, const char* first) {
    std::vector<std::uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13};
    png.insert(png.end(), first, first + 4);
    for (const std::uint32_t v : {width, height})
      for (int shift = 24; shift >= 0; shift -= 8) png.push_back(std::uint8_t(v >> shift));
    png.insert(png.end(), {8, 0, 0, 0, 0, 0, 0, 0, 0});
    try {
      read_grey_png(std::as_bytes(std::span(png)));
    } catch (const PngError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(refused(0, 0x49454002, "IHDR") == "has no pixels");
  CHECK(refused(5, 0, "IHDR") == "has no pixels");
  CHECK(refused(1, 1'000'001, "IHDR") == "has more than 1,000,000 rows");
  CHECK(refused(0x10000, 0x10000, "IHDR") == "has more than 2^28 pixels");
  CHECK(refused(5, 5, "IEND") == "is not a PNG file");
}

TEST_CASE("What Firn writes as PNG another library reads to the same pixels") {
  RandomStream random(5, Purpose::kTest);
  for (const int channels : {3, 4}) {
    std::vector<std::uint8_t> pixels(std::size_t(7 * 5 * channels));
    for (std::uint8_t& p : pixels) p = std::uint8_t(random.below(256));
    std::vector<std::byte> bytes = write_png(7, 5, channels, pixels);
    const cv::Mat image =
        cv::imdecode(cv::Mat(1, int(bytes.size()), CV_8U, bytes.data()), cv::IMREAD_UNCHANGED);
    REQUIRE(image.size() == cv::Size(7, 5));
    REQUIRE(image.channels() == channels);
    for (int n = 0; n < 35; ++n)
      for (int c = 0; c < channels; ++c)  // OpenCV's order is blue, green, red
        CHECK(image.data[n * channels + (c < 3 ? 2 - c : c)] == pixels[std::size_t(n * channels + c)]);
  }
  CHECK_THROWS_AS(write_png(7, 5, 3, std::vector<std::uint8_t>(104)), PngError);
  CHECK_THROWS_AS(read_grey_png(write_png(1, 1, 3, std::vector<std::uint8_t>(3))), PngError);
}

TEST_CASE("Any byte of a picture may be wrong: a target or a ConfigError, never a crash") {
  cv::Mat image(20, 20, CV_16U);
  for (int r = 0; r < 20; ++r)
    for (int c = 0; c < 20; ++c) image.at<std::uint16_t>(r, c) = std::uint16_t(r * 3000 + c);
  const std::vector<std::byte> good = png(image);
  RandomStream random(3, Purpose::kTest);
  int refused = 0;
  for (int n = 0; n < 400; ++n) {
    std::vector<std::byte> bytes = good;
    if (n % 3 == 0)
      bytes.resize(random.below(std::uint32_t(bytes.size())));
    else
      bytes[random.below(std::uint32_t(bytes.size()))] = std::byte(random.below(256));
    try {
      for (double h : target_from_png(bytes, grid(10, 10), 0.4, "x.png").height.cells)
        REQUIRE((h >= 0.0 && h <= 0.4 + 1e-12));
    } catch (const ConfigError&) {
      ++refused;
    }
  }
  CHECK(refused > 100);
}

TEST_CASE("Inputs of an analytic shape are the target and the mask as NPY, named by their SHA-256") {
  const Experiment e;
  const Blobs blobs = make_inputs(full_product(), e, "");
  REQUIRE(blobs.size() == 2);
  CHECK(blobs[0].role == "target");
  CHECK(blobs[1].role == "mask");
  for (const Blob& b : blobs) CHECK(b.sha256 == sha256_hex(b.bytes));
  const Target t = make_shape(e.part.shape, e.grid);
  CHECK(height_map_from_npy(blobs[0].bytes, e.grid, "target") == t.height);
  CHECK(mask_from_npy(blobs[1].bytes, e.grid, "mask") == t.mask);
}

TEST_CASE("A part that covers no cell centre, and a picture that is not there, are configuration errors") {
  Experiment e;
  e.part.shape.diameter_mm = 0.01;  // on an even grid the centre lies between cells
  CHECK_THROWS_AS(make_inputs(full_product(), e, ""), ConfigError);
  e.part.shape.kind = "height_map";
  e.part.image = "nowhere.png";
  CHECK_THROWS_WITH(make_inputs(full_product(), e, "folder"),
                    Catch::Contains("folder/nowhere.png") && Catch::Contains("no such file"));
}
