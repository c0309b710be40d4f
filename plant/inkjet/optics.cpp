#include "plant/inkjet/optics.h"

#include <algorithm>
#include <cmath>

namespace firn::plant {

void blur_picture(std::vector<float>& f, int w, int h, double sigma) {
  if (sigma <= 0) return;
  const int reach = int(std::ceil(4 * sigma));
  std::vector<float> kernel;
  float sum = 0;
  for (int i = -reach; i <= reach; ++i)
    sum += kernel.emplace_back(float(std::exp(-0.5 * i * i / (sigma * sigma))));
  for (float& k : kernel) k /= sum;
  std::vector<float> line(std::size_t(std::max(w, h)));
  const auto pass = [&](std::size_t begin, std::size_t stride, int n) {
    float least = f[begin], most = f[begin];
    for (int i = 0; i < n; ++i) {
      line[std::size_t(i)] = f[begin + std::size_t(i) * stride];
      least = std::min(least, line[std::size_t(i)]);
      most = std::max(most, line[std::size_t(i)]);
    }
    if (least == most) return;
    for (int i = 0; i < n; ++i) {
      float s = 0;
      for (int k = -reach; k <= reach; ++k)
        s += kernel[std::size_t(k + reach)] * line[std::size_t(std::clamp(i + k, 0, n - 1))];
      f[begin + std::size_t(i) * stride] = s;
    }
  };
  for (int y = 0; y < h; ++y) pass(std::size_t(y) * std::size_t(w), 1, w);
  for (int x = 0; x < w; ++x) pass(std::size_t(x), std::size_t(w), h);
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
