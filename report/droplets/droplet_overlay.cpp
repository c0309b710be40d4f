#include <algorithm>
#include <array>
#include <cmath>

#include "core/grid/png.h"
#include "files/picture/read_picture.h"
#include "report/droplets/droplet_files.h"

namespace firn::report {
namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kMain{40, 220, 90}, kOther{70, 150, 255}, kSatellite{255, 150, 40}, kNozzle{0, 220, 230};

struct Canvas {
  int width, height;
  std::vector<std::uint8_t> rgb;

  void blend(int x, int y, const Colour& c, double share) {
    if (x < 0 || y < 0 || x >= width || y >= height || share <= 0) return;
    std::uint8_t* p = &rgb[3 * (std::size_t(y) * std::size_t(width) + std::size_t(x))];
    for (int k = 0; k < 3; ++k) p[k] = std::uint8_t(p[k] + std::min(1.0, share) * (c[std::size_t(k)] - p[k]));
  }
  void circle(double cx, double cy, double r, const Colour& c) {
    const double half = 0.9;
    for (int y = int(cy - r - 3); y <= int(cy + r + 3); ++y)
      for (int x = int(cx - r - 3); x <= int(cx + r + 3); ++x)
        blend(x, y, c, half + 0.5 - std::abs(std::sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy)) - r));
  }
  void segment(double x0, double y0, double x1, double y1, const Colour& c) {
    const double dx = x1 - x0, dy = y1 - y0, length2 = std::max(1e-9, dx * dx + dy * dy);
    for (int y = int(std::min(y0, y1) - 3); y <= int(std::max(y0, y1) + 3); ++y)
      for (int x = int(std::min(x0, x1) - 3); x <= int(std::max(x0, x1) + 3); ++x) {
        const double t = std::clamp(((x - x0) * dx + (y - y0) * dy) / length2, 0.0, 1.0);
        blend(x, y, c,
              1.2 - std::sqrt((x - x0 - t * dx) * (x - x0 - t * dx) + (y - y0 - t * dy) * (y - y0 - t * dy)));
      }
  }
};

}  // namespace

std::vector<std::byte> droplet_overlay(const AnalysedPicture& picture) {
  const DecodedPicture p = read_picture(picture.file);
  Canvas canvas{p.width, p.height, {}};
  canvas.rgb.reserve(3 * p.pixels.size());
  for (const std::uint16_t v : p.pixels)
    for (int k = 0; k < 3; ++k) canvas.rgb.push_back(std::uint8_t(int(v) * 255 / p.white));
  const vision::DropletPicture& r = picture.result;
  if (r.nozzle.found) {
    const double half = 0.5 * r.nozzle.width_px, x = r.nozzle.edge.x, y = r.nozzle.edge.y;
    canvas.segment(x - half * r.nozzle.flight.y, y + half * r.nozzle.flight.x, x + half * r.nozzle.flight.y,
                   y - half * r.nozzle.flight.x, kNozzle);
  }
  for (const vision::Droplet& d : r.satellites)
    canvas.circle(d.x, d.y, 0.5 * d.diameter_px + 1.5, kSatellite);
  for (const vision::Droplet& d : r.drops) canvas.circle(d.x, d.y, 0.5 * d.diameter_px, kOther);
  if (r.state != vision::PictureState::kNoDrop) {
    canvas.circle(r.main.x, r.main.y, 0.5 * r.main.diameter_px, kMain);
    canvas.segment(r.main.x - 4, r.main.y, r.main.x + 4, r.main.y, kMain);
    canvas.segment(r.main.x, r.main.y - 4, r.main.x, r.main.y + 4, kMain);
    if (r.state == vision::PictureState::kNotBrokenOff && r.nozzle.found)
      canvas.segment(r.main.x, r.main.y, r.nozzle.edge.x, r.nozzle.edge.y, kSatellite);
  }
  return write_png(p.width, p.height, 3, canvas.rgb);
}

}  // namespace firn::report
