#include "plant/inkjet/optics.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {

// A row or a column of equal values stays as it is.
void blur_picture(std::vector<float>& f, int w, int h, double sigma) {
  if (sigma <= 0) return;
  const int reach = int(std::ceil(4 * sigma));
  std::vector<float> kernel;
  float weights = 0;
  for (int i = -reach; i <= reach; ++i)
    weights += kernel.emplace_back(float(std::exp(-0.5 * i * i / (sigma * sigma))));
  for (float& k : kernel) k /= weights;
  const auto wide = std::size_t(w), high = std::size_t(h), taps = kernel.size();
  std::vector<float> line(wide + taps - 1), sum(wide), least(wide), most(wide);
  for (std::size_t y = 0; y < high; ++y) {
    float* row = f.data() + y * wide;
    const auto [low, top] = std::minmax_element(row, row + wide);
    if (*low == *top) continue;
    for (std::size_t i = 0; i < line.size(); ++i) line[i] = row[std::clamp(int(i) - reach, 0, w - 1)];
    std::ranges::fill(sum, 0.0f);
    for (std::size_t k = 0; k < taps; ++k)
      for (std::size_t x = 0; x < wide; ++x) sum[x] += kernel[k] * line[x + k];
    std::ranges::copy(sum, row);
  }
  const std::vector<float> rows = f;
  std::copy_n(rows.begin(), wide, least.begin());
  most = least;
  for (std::size_t y = 1; y < high; ++y)
    for (std::size_t x = 0; x < wide; ++x) {
      least[x] = std::min(least[x], rows[y * wide + x]);
      most[x] = std::max(most[x], rows[y * wide + x]);
    }
  for (std::size_t y = 0; y < high; ++y) {
    std::ranges::fill(sum, 0.0f);
    for (std::size_t k = 0; k < taps; ++k) {
      const float* from = rows.data() + wide * std::size_t(std::clamp(int(y + k) - reach, 0, h - 1));
      for (std::size_t x = 0; x < wide; ++x) sum[x] += kernel[k] * from[x];
    }
    for (std::size_t x = 0; x < wide; ++x)
      f[y * wide + x] = least[x] == most[x] ? rows[y * wide + x] : sum[x];
  }
}

std::vector<float> soiled(std::span<const Speck> specks, int width, int height) {
  std::vector<float> dirt(std::size_t(width) * std::size_t(height));
  for (const Speck& s : specks) {
    const double reach = s.radius_px + 4 * s.blur_px;
    for (int y = std::max(0, int(s.y_px - reach)); y <= std::min(height - 1, int(s.y_px + reach)); ++y)
      for (int x = std::max(0, int(s.x_px - reach)); x <= std::min(width - 1, int(s.x_px + reach)); ++x) {
        const double r = std::hypot(x - s.x_px, y - s.y_px),
                     edge = 0.5 * std::erfc((r - s.radius_px) / (std::sqrt(2.0) * (s.blur_px + 0.3)));
        float& f = dirt[std::size_t(y) * std::size_t(width) + std::size_t(x)];
        f = float(1 - (1 - f) * (1 - s.opacity * edge));
      }
  }
  return dirt;
}

}  // namespace firn::plant
