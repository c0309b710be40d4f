#include "plant/aerosol/line_picture.h"

#include <algorithm>
#include <cmath>

#include "core/grid/random.h"

namespace firn::plant {
namespace {

constexpr int kPointsPerSide = 2;  // of a pixel's square
constexpr double kUmPerMm = 1e3;

// Mean contrast of the ink under each pixel.
std::vector<float> covered(const LineCamera& c, const std::function<double(double, double)>& thickness_mm) {
  std::vector<float> field(std::size_t(c.width) * std::size_t(c.height));
  if (!thickness_mm) return field;
  const double scale = c.um_per_px / kUmPerMm, cosine = std::cos(c.turn), sine = std::sin(c.turn);
  std::size_t n = 0;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x) {
      double sum = 0.0;
      for (int j = 0; j < kPointsPerSide; ++j)
        for (int i = 0; i < kPointsPerSide; ++i) {
          const double u = scale * (x - 0.5 * (c.width - 1) + (i + 0.5) / kPointsPerSide - 0.5),
                       v = -scale * (y - 0.5 * (c.height - 1) + (j + 0.5) / kPointsPerSide - 0.5);
          sum += ink_contrast(thickness_mm(c.x_mm + cosine * u - sine * v, c.y_mm + sine * u + cosine * v),
                              c.optical_depth_mm);
        }
      field[n++] = float(sum / (kPointsPerSide * kPointsPerSide));
    }
  return field;
}

}  // namespace

double ink_contrast(double thickness_mm, double optical_depth_mm) {
  return thickness_mm > 0.0 ? 1.0 - std::exp(-thickness_mm / optical_depth_mm) : 0.0;
}

TakenPicture render_lines(const LineCamera& c, const std::function<double(double, double)>& thickness_mm,
                          std::uint64_t seed, std::uint32_t exposure) {
  TakenPicture p{c.width, c.height, c.white, {}};
  RandomStream random(seed, Purpose::kSensorNoise, exposure, 1);
  std::vector<float> ink = covered(c, thickness_mm);
  blur_picture(ink, c.width, c.height, c.blur_px);
  const std::vector<float> dirt = soiled(c.dirt, c.width, c.height);
  const double strobe = 1 + c.flicker * random.normal();
  p.pixels.reserve(ink.size());
  std::size_t n = 0;
  for (int y = 0; y < c.height; ++y)
    for (int x = 0; x < c.width; ++x, ++n) {
      const double fx = 2.0 * x / c.width - 1, fy = 2.0 * y / c.height - 1;
      const double ground = c.light * (1 + 0.5 * c.slope_x * fx + 0.5 * c.slope_y * fy -
                                       0.5 * c.vignette * (fx * fx + fy * fy));
      const double share = c.contrast * double(ink[n]);
      double level = c.bright ? ground * (0.3 + 0.7 * share) : ground * (1 - share);
      level = std::max(0.0, level * (1 - double(dirt[n])) * strobe);
      level += c.read_noise * random.normal() + c.shot_noise * std::sqrt(level) * random.normal();
      p.pixels.push_back(std::uint16_t(std::clamp(level * c.white + 0.5, 0.0, double(c.white))));
    }
  return p;
}

}  // namespace firn::plant
