// V4L2 cameras: pixels of each format, negotiation, and frames that are short, old, damaged or never come.
#include <catch2/catch.hpp>

#include <cstdlib>

#include <opencv2/imgcodecs.hpp>

#include "core/grid/random.h"
#include "runtime/camera/jpeg_frame.h"
#include "runtime/camera/v4l2_source.h"
#include "tests/runtime/fake_video_device.h"

namespace firn::test {
namespace {

using namespace firn::camera;
using Catch::Contains;

/// Bytes of a picture of these levels, packed by shifts and by hand, apart from the code under test.
std::vector<std::byte> packed(const PixelFormat& f, const std::vector<std::uint16_t>& levels, int width,
                              std::size_t stride, RandomStream& random) {
  const std::size_t rows = levels.size() / std::size_t(width);
  std::vector<std::byte> bytes(stride * rows);
  for (std::byte& b : bytes) b = std::byte(random.below(256));  // chroma and padding are anything
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < std::size_t(width); ++x) {
      const std::uint16_t v = levels[y * std::size_t(width) + x];
      const std::size_t at = y * stride + (f.name == "GREY" ? x : 2 * x);
      bytes[at] = std::byte(v & 0xFF);
      if (f.name != "GREY" && f.name != "YUYV") {
        const unsigned above = 0xFFFFu & ~unsigned(f.white) & random.below(65536);  // bits that mean nothing
        bytes[at + 1] = std::byte((v | above) >> 8);
      }
    }
  return bytes;
}

std::vector<std::uint16_t> drawn_levels(const PixelFormat& f, int count, RandomStream& random) {
  std::vector<std::uint16_t> levels(static_cast<std::size_t>(count));
  for (auto& v : levels) v = std::uint16_t(random.below(std::uint32_t(f.white) + 1));
  return levels;
}

FakeFrame frame_at(std::int64_t us, std::uint8_t level = 7, std::size_t bytes = 32 * 16) {
  return {std::vector<std::uint8_t>(bytes, level), us, false, true};
}

struct Rig {
  FakeCamera camera;
  std::unique_ptr<V4l2Source> source;
  V4l2Source& open(V4l2Options options = {}) {
    source = std::make_unique<V4l2Source>(std::make_unique<FakeVideoDevice>(camera), options);
    return *source;
  }
  std::string refusal(V4l2Options options = {}) {
    try {
      open(options);
    } catch (const std::runtime_error& why) {
      return why.what();
    }
    return {};
  }
};

}  // namespace

TEST_CASE("grey levels of every V4L2 format come back from packed bytes, whatever padding and chroma hold") {
  for (const PixelFormat& f : pixel_formats())
    for (std::uint64_t seed = 0; f.name != "MJPG" && seed < 100; ++seed) {
      RandomStream random(seed, Purpose::kTest);
      const int width = 2 * (1 + int(random.below(20))), height = 1 + int(random.below(12));
      const std::size_t stride = row_bytes(f, width) + random.below(9);
      const auto levels = drawn_levels(f, width * height, random);
      INFO(f.name << ", seed " << seed);
      CHECK(grey_levels(f, width, height, stride, packed(f, levels, width, stride, random)) == levels);
    }
}

TEST_CASE(
    "a frame one byte short of its last row is refused, and one without the last row's padding is taken") {
  for (const PixelFormat& f : pixel_formats()) {
    if (f.name == "MJPG") continue;  // its frames have no rows
    const std::size_t stride = row_bytes(f, 16) + 5, needed = stride * 7 + row_bytes(f, 16);
    const std::vector<std::byte> bytes(needed);
    CHECK_NOTHROW(grey_levels(f, 16, 8, stride, bytes));
    CHECK_THROWS_AS(grey_levels(f, 16, 8, stride, std::span(bytes).first(needed - 1)), std::length_error);
  }
}

TEST_CASE("an odd YUYV width has its last pixel in a whole pair") {
  const PixelFormat& f = *pixel_format("YUYV");
  CHECK(row_bytes(f, 5) == 12);
  const std::vector<std::byte> bytes{std::byte(1), std::byte(128), std::byte(2), std::byte(128),
                                     std::byte(3), std::byte(128), std::byte(0), std::byte(128)};
  CHECK(grey_levels(f, 3, 1, 8, bytes) == std::vector<std::uint16_t>{1, 2, 3});
}

TEST_CASE("the deepest of the known formats is chosen") {
  Rig rig;
  rig.camera.formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_GREY, V4L2_PIX_FMT_Y12};
  V4l2Source& source = rig.open();
  rig.camera.frames.push_back(frame_at(rig.camera.now_us, 0xFF, 2 * 32 * 16));
  const GreyShot shot = source.take({});
  CHECK(shot.white == 4095);
  CHECK(shot.pixels.front() == 4095);
}

TEST_CASE("a format that the address names is chosen before a deeper one") {
  Rig rig;
  rig.camera.formats = {V4L2_PIX_FMT_Y16, V4L2_PIX_FMT_GREY};
  V4l2Source& source = rig.open({0, 0, "GREY", 0.0});
  rig.camera.frames.push_back(frame_at(rig.camera.now_us));
  CHECK(source.take({}).white == 255);
}

TEST_CASE("a camera that offers MJPG alone gives the picture within what JPEG loses") {
  Rig rig;
  rig.camera.formats = {V4L2_PIX_FMT_MJPEG};
  rig.camera.width = 64;
  rig.camera.height = 48;
  V4l2Source& source = rig.open({0, 0, "", 0.0, &decode_jpeg_frame});
  cv::Mat picture(48, 64, CV_8UC1);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) picture.at<std::uint8_t>(y, x) = std::uint8_t(40 + 2 * x + y);
  FakeFrame frame = frame_at(rig.camera.now_us);
  REQUIRE(cv::imencode(".jpg", picture, frame.bytes, {cv::IMWRITE_JPEG_QUALITY, 90}));
  SECTION("whole frames") {
    rig.camera.frames.push_back(frame);
    const GreyShot shot = source.take({});
    REQUIRE(shot.pixels.size() == picture.total());
    CHECK(shot.white == 255);
    constexpr int kLoss = 6;  // grey levels, of a smooth picture at this quality
    for (int y = 0; y < picture.rows; ++y)
      for (int x = 0; x < picture.cols; ++x)
        REQUIRE(std::abs(shot.pixels[std::size_t(y * 64 + x)] - picture.at<std::uint8_t>(y, x)) <= kLoss);
  }
  SECTION("cut and foreign frames are passed over") {
    FakeFrame cut = frame, small = frame;
    cut.bytes.resize(cut.bytes.size() / 2);
    REQUIRE(cv::imencode(".jpg", picture.rowRange(0, 40), small.bytes));
    rig.camera.frames = {cut, small, frame};
    CHECK(source.take({}).pixels.size() == picture.total());
  }
  SECTION("sixteen damaged frames are named by their damage") {
    FakeFrame cut = frame;
    cut.bytes.resize(cut.bytes.size() / 2);
    rig.camera.frames.assign(16, cut);
    CHECK_THROWS_WITH(source.take({}), Contains("16 frames in a row are damaged: a JPEG frame: damaged"));
  }
}

TEST_CASE("a V4L2 device that cannot serve is refused by what it lacks") {
  Rig rig;
  SECTION("formats") {
    rig.camera.formats = {V4L2_PIX_FMT_MJPEG};
    CHECK_THAT(rig.refusal(), Contains("offers MJPG, none of Y16, Y12, Y10, GREY, YUYV"));
  }
  SECTION("capture") {
    rig.camera.capabilities = V4L2_CAP_STREAMING;
    CHECK_THAT(rig.refusal(), Contains("captures no pictures"));
  }
  SECTION("streaming") {
    rig.camera.capabilities = V4L2_CAP_VIDEO_CAPTURE;
    CHECK_THAT(rig.refusal(), Contains("cannot stream"));
  }
  SECTION("the format asked for") {
    rig.camera.given = V4L2_PIX_FMT_MJPEG;
    CHECK_THAT(rig.refusal(), Contains("gives MJPG where GREY was asked for"));
  }
  SECTION("the size asked for") {
    CHECK_THAT(rig.refusal({640, 480, "", 0.0}), Contains("gives 32 x 16 px where 640 x 480"));
  }
  SECTION("buffers") {
    rig.camera.max_buffers = 1;
    CHECK_THAT(rig.refusal(), Contains("1 buffers, 2 are needed"));
  }
  SECTION("a side") {
    rig.camera.height = 8;
    CHECK_THAT(rig.refusal(), Contains("outside [16, 16384]"));
  }
  CHECK(rig.camera.mapped == 0);
}

TEST_CASE("interrupted calls of a V4L2 device are made again") {
  Rig rig;
  rig.camera.interrupts = 5;
  V4l2Source& source = rig.open();
  rig.camera.interrupts = 3;
  rig.camera.frames.push_back(frame_at(rig.camera.now_us));
  CHECK(source.take({}).pixels.front() == 7);
}

TEST_CASE("frames exposed before the picture was asked for are given back") {
  Rig rig;
  V4l2Source& source = rig.open();
  rig.camera.frames = {frame_at(rig.camera.now_us - 1, 1), frame_at(rig.camera.now_us + 5, 2)};
  CHECK(source.take({}).pixels.front() == 2);
  CHECK(rig.camera.queued == 4);
}

TEST_CASE("two frames without a time are passed, as they may be old") {
  Rig rig;
  V4l2Source& source = rig.open();
  for (std::uint8_t level = 1; level <= 3; ++level) {
    rig.camera.frames.push_back(frame_at(0, level));
    rig.camera.frames.back().stamped = false;
  }
  CHECK(source.take({}).pixels.front() == 3);
}

TEST_CASE("short and damaged frames are given back for whole ones") {
  Rig rig;
  V4l2Source& source = rig.open();
  rig.camera.frames = {frame_at(rig.camera.now_us, 1, 100), frame_at(rig.camera.now_us, 2),
                       frame_at(rig.camera.now_us, 3)};
  rig.camera.frames[1].damaged = true;
  CHECK(source.take({}).pixels.front() == 3);
}

TEST_CASE("a device that gives only short frames fails the picture, not the port") {
  Rig rig;
  V4l2Source& source = rig.open();
  for (int n = 0; n < 20; ++n) rig.camera.frames.push_back(frame_at(rig.camera.now_us, 1, 100));
  CHECK_THROWS_WITH(source.take({}), Contains("16 frames in a row") && Contains("100 bytes"));
}

TEST_CASE("a device without a frame fails the picture after exposure and two seconds") {
  Rig rig;
  V4l2Source& source = rig.open();
  CHECK(source.set_up({500'000.0, 0.0, 0.0}).empty());
  CHECK_THROWS_WITH(source.take({}), Contains("no picture within 2500 ms"));
}

TEST_CASE("an unplugged device ends the source") {
  Rig rig;
  V4l2Source& source = rig.open();
  rig.camera.unplugged = true;
  CHECK_THROWS_AS(source.take({}), SourceGone);
}

TEST_CASE("the exposure is set in the control's hundreds of microseconds") {
  Rig rig;
  V4l2Source& source = rig.open();
  CHECK(source.set_up({2'340.0, 0.0, 0.0}).empty());
  CHECK(rig.camera.set[V4L2_CID_EXPOSURE_ABSOLUTE] == 23);
  CHECK(rig.camera.set[V4L2_CID_EXPOSURE_AUTO] == V4L2_EXPOSURE_MANUAL);
}

TEST_CASE("settings that a V4L2 device cannot have are refused") {
  Rig rig;
  V4l2Source& source = rig.open({0, 0, "", 60.0});
  CHECK_THAT(source.set_up({100.0, 0.0, 72.0}), Contains("strobe delay"));
  CHECK_THAT(source.set_up({100.0, 6.0, 60.0}), Contains("gain: the device has no such control"));
  CHECK_THAT(source.set_up({5e6, 0.0, 60.0}), Contains("outside [1, 10000]"));
  CHECK(source.set_up({100.0, 0.0, 60.0}).empty());
}

TEST_CASE("a V4L2 device gives its buffers back and stops streaming") {
  Rig rig;
  rig.open();
  CHECK(rig.camera.streaming);
  rig.source.reset();
  CHECK(rig.camera.mapped == 0);
  CHECK_FALSE(rig.camera.streaming);
}

}  // namespace firn::test
