#include "plant/aerosol/line_picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/grid/random_normals.h"

namespace firn::plant {
namespace {

constexpr std::size_t kPointsPerSide = 2;  // of a pixel's square
constexpr double kUmPerMm = 1e3;

// Mean contrast of the ink under each pixel.
std::vector<float> covered(const LineCamera& c, const InkThickness& thickness) {
  const auto wide = std::size_t(c.width), high = std::size_t(c.height);
  std::vector<float> field(wide * high);
  if (!thickness) return field;
  const double scale = c.um_per_px / kUmPerMm, cosine = std::cos(c.turn), sine = std::sin(c.turn);
  std::vector<double> x_mm(kPointsPerSide * wide), y_mm(x_mm.size()), ink(x_mm.size()), sum(wide);
  for (std::size_t y = 0; y < high; ++y) {
    std::ranges::fill(sum, 0.0);
    for (std::size_t j = 0; j < kPointsPerSide; ++j) {
      const double v = -scale * (double(y) - 0.5 * (c.height - 1) + (double(j) + 0.5) / kPointsPerSide - 0.5);
      for (std::size_t n = 0; n < ink.size(); ++n) {
        const std::size_t x = n / kPointsPerSide, i = n % kPointsPerSide;
        const double u = scale * (double(x) - 0.5 * (c.width - 1) + (double(i) + 0.5) / kPointsPerSide - 0.5);
        x_mm[n] = c.x_mm + cosine * u - sine * v;
        y_mm[n] = c.y_mm + sine * u + cosine * v;
      }
      thickness(x_mm, y_mm, ink);
      for (std::size_t n = 0; n < ink.size(); ++n)
        sum[n / kPointsPerSide] += ink_contrast(ink[n], c.optical_depth_mm);
    }
    for (std::size_t x = 0; x < wide; ++x)
      field[y * wide + x] = float(sum[x] / (kPointsPerSide * kPointsPerSide));
  }
  return field;
}

}  // namespace

double ink_contrast(double thickness_mm, double optical_depth_mm) {
  return thickness_mm > 0.0 ? 1.0 - std::exp(-thickness_mm / optical_depth_mm) : 0.0;
}

TakenPicture render_lines(const LineCamera& c, const InkThickness& thickness, std::uint64_t seed,
                          std::uint32_t exposure) {
  TakenPicture p{c.width, c.height, c.white, {}};
  const auto wide = std::size_t(c.width), high = std::size_t(c.height);
  std::vector<float> ink = covered(c, thickness);
  blur_picture(ink, c.width, c.height, c.blur_px);
  const std::vector<float> dirt = soiled(c.dirt, c.width, c.height);
  DrawKey key{seed, Purpose::kSensorNoise, exposure, 1, 0};
  const double strobe = 1 + c.flicker * random_normal(key);
  ++key.cell;
  p.pixels.resize(ink.size());
  std::vector<double> normal(2 * wide);
  for (std::size_t y = 0; y < high; ++y) {
    random_normals(key, normal);
    key.cell += std::uint32_t(normal.size());
    const double fy = 2.0 * double(y) / c.height - 1;
    for (std::size_t x = 0; x < wide; ++x) {
      const std::size_t n = y * wide + x;
      const double fx = 2.0 * double(x) / c.width - 1;
      const double ground = c.light * (1 + 0.5 * c.slope_x * fx + 0.5 * c.slope_y * fy -
                                       0.5 * c.vignette * (fx * fx + fy * fy));
      const double share = c.contrast * double(ink[n]);
      double level = c.bright ? ground * (0.3 + 0.7 * share) : ground * (1 - share);
      level = std::max(0.0, level * (1 - double(dirt[n])) * strobe);
      level += c.read_noise * normal[2 * x] + c.shot_noise * std::sqrt(level) * normal[2 * x + 1];
      p.pixels[n] = std::uint16_t(std::clamp(level * c.white + 0.5, 0.0, double(c.white)));
    }
  }
  return p;
}

}  // namespace firn::plant
