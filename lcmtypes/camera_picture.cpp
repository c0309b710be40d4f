#include "lcmtypes/camera_picture.h"

#include <algorithm>
#include <span>

#include "core/grid/png.h"

namespace firn {

vision::Frame frame_of(const camera_frame_t& m) {
  const GreyPicture grey = read_grey_png(std::as_bytes(std::span(m.png)));
  if (grey.width != m.width || grey.height != m.height) throw PngError("is not as large as the message says");
  vision::Frame f{grey.width, grey.height, m.white, std::vector<std::uint16_t>(grey.pixels.size())};
  std::ranges::transform(grey.pixels, f.pixels.begin(), [](double v) { return std::uint16_t(v); });
  return f;
}

}  // namespace firn
