// Any bytes as a CAMERA_FRAME of a line and the way it is looked at: a reading of finite numbers, or a
// PngError. The PNG file is the bytes themselves, checksums made true, or written of runs of their values.
#include <cmath>
#include <vector>

#include "core/grid/png.h"
#include "core/vision/line_picture.h"
#include "lcmtypes/camera_picture.h"
#include "tests/fuzz/png_bytes.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;
using namespace firn::vision;

namespace {

constexpr std::size_t kHead = 12;
constexpr int kWhites[] = {255, 1023, 4095, 65535};

std::vector<std::uint8_t> written(const std::uint8_t* data, std::size_t size, int width, int height,
                                  int white, std::size_t repeat) {
  std::vector<std::uint16_t> pixels;
  for (std::size_t i = 0; i < std::size_t(width) * std::size_t(height); ++i)
    pixels.push_back(std::uint16_t(data[(i / repeat) % size] * (white / 255)));
  const std::vector<std::byte> png = write_grey_png(width, height, white, pixels);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(png.data());
  return {bytes, bytes + png.size()};
}

void check(const LinePictureReading& r, const LineView& view) {
  for (const double v : {r.left_px, r.right_px, r.width_px, r.contrast, r.overspray, r.read_px})
    require(std::isfinite(v), "a reading is finite");
  for (const double v : {r.left_std_px, r.right_std_px, r.width_std_px, r.overspray_std})
    require(std::isfinite(v) && v >= 0.0, "a standard deviation is finite");
  if (r.seen) {
    require(r.width_px > 0.0 && r.left_px > r.right_px, "a line has a width");
    require(std::abs(r.left_px) <= view.window_px + 1 && std::abs(r.right_px) <= view.window_px + 1,
            "edges lie in the window");
  }
  for (const LineGap& g : r.gaps)
    require(g.from_px >= 0.0 && g.to_px > g.from_px && g.to_px <= view.length_px + 1 && g.std_px > 0.0,
            "a gap lies in the stretch");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHead + 8) return 0;
  const std::uint8_t *body = data + kHead, *h = data;
  const std::size_t rest = size - kHead;
  camera_frame_t m{};
  m.white = kWhites[h[0] % 4];
  m.width = kMinSide + h[1] % 48;
  m.height = kMinSide + h[2] % 48;
  m.png =
      h[0] & 128 ? written(body, rest, m.width, m.height, m.white, 1 + h[3] % 32) : mended_png(body, rest);
  LineView view;
  view.middle = {h[4] / 2.0 - 32, h[5] / 2.0 - 32};
  const double u = (h[6] - 128) / 128.0, v = std::sqrt(std::max(0.0, 1 - u * u));
  view.direction = h[7] & 1 ? Point{u, v} : Point{h[7] & 2 ? 1.0 : 0.0, h[7] & 2 ? 0.0 : -1.0};
  view.length_px = h[8] / 4.0;
  view.width_px = h[9] / 8.0;
  view.window_px = 6 + h[10] / 8.0;
  LinePictureOptions options;
  options.blur_px = h[11] / 32.0;
  try {
    if (!(h[0] & 128)) {
      const PngHeader header = png_header(as_bytes(m.png.data(), m.png.size()));
      if (std::uint64_t(header.width) * header.height > 1u << 12) return 0;  // time goes into memory alone
      m.width = std::int32_t(header.width);
      m.height = std::int32_t(header.height);
    }
    const Frame frame = frame_of(m);
    if (!(h[0] & 64)) {
      check(measure_line_picture(frame, nullptr, view, options), view);
      return 0;
    }
    Frame other = frame;
    for (std::size_t i = 0; i < other.pixels.size(); i += 3)
      other.pixels[i] = std::uint16_t(m.white - std::min<int>(m.white, frame.pixels[i]));
    const Frame* const bare[] = {&other, &frame};
    const Frame flat = flat_field(bare);
    check(measure_line_picture(frame, &flat, view, options), view);
  } catch (const PngError&) {
  }
  return 0;
}
