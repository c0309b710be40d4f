#include "core/vision/writing.h"

#include <algorithm>
#include <cstdlib>

namespace firn::vision {
namespace {

constexpr int kLeast_px = 6;              // height of a character that can be told from a spot
constexpr int kMostShare = 8;             // of the picture's height
constexpr double kAlike = 0.15;           // of heights and baselines, share of the height
constexpr double kApart = 1.2;            // gap between characters over their height
constexpr double kRound[] = {0.8, 1.25};  // width over height of what may be a droplet
constexpr double kWords = 2.0;            // gap between words over the height of their characters
constexpr double kBar = 0.6;              // least share of a bar in its box
constexpr std::size_t kLeastLetters = 3;

int height_of(const Component& c) { return c.y1 - c.y0 + 1; }
int width_of(const Component& c) { return c.x1 - c.x0 + 1; }
bool is_round(const Component& c) {
  const double ratio = double(width_of(c)) / height_of(c);
  return ratio > kRound[0] && ratio < kRound[1];
}

bool side_by_side(const Component& a, const Component& b) {
  const int h = std::max(height_of(a), height_of(b)), alike = std::max(1, int(kAlike * h));
  return std::abs(height_of(a) - height_of(b)) <= alike && std::abs(a.y1 - b.y1) <= alike &&
         std::max(a.x0, b.x0) - std::min(a.x1, b.x1) <= kApart * h;
}

bool lies_inside(const Component& c, const Component& b) {
  return c.x0 >= b.x0 && c.x1 <= b.x1 && c.y0 >= b.y0 && c.y1 <= b.y1;
}

}  // namespace

std::vector<bool> find_writing(const std::vector<Component>& components,
                               const std::vector<std::size_t>& order, const Frame& frame) {
  std::vector<bool> written(components.size());
  std::vector<std::size_t> letters;
  for (const std::size_t i : order)
    if (!components[i].at_edge && height_of(components[i]) >= kLeast_px &&
        height_of(components[i]) * kMostShare <= frame.height)
      letters.push_back(i);
  for (const std::size_t bar : order) {
    const Component& b = components[bar];
    if (width_of(b) < frame.width || double(b.area) < kBar * width_of(b) * height_of(b)) continue;
    for (const std::size_t i : order) written[i] = written[i] || (i != bar && lies_inside(components[i], b));
  }
  std::vector<bool> taken(components.size());
  for (const std::size_t first : letters) {
    if (taken[first]) continue;
    taken[first] = true;
    std::vector<std::size_t> line{first};
    for (std::size_t k = 0; k < line.size(); ++k)
      for (const std::size_t i : letters)
        if (!taken[i] && side_by_side(components[line[k]], components[i])) {
          taken[i] = true;
          line.push_back(i);
        }
    const auto slim = std::ranges::count_if(line, [&](std::size_t i) { return !is_round(components[i]); });
    if (line.size() < kLeastLetters || 2 * slim < std::ptrdiff_t(line.size())) continue;
    int x0 = components[first].x0, x1 = components[first].x1, tallest = 0;
    for (const std::size_t i : line) {
      x0 = std::min(x0, components[i].x0);
      x1 = std::max(x1, components[i].x1);
      tallest = std::max(tallest, height_of(components[i]));
    }
    // Words go on over gaps, with smaller and deeper characters, points and strokes.
    const int more = int(kWords * tallest), deep = tallest / 3, base = components[first].y1;
    for (bool grows = true; grows;) {
      grows = false;
      for (const std::size_t i : order) {
        const Component& c = components[i];
        if (written[i] || c.at_edge || c.x1 < x0 - more || c.x0 > x1 + more || c.y1 > base + deep ||
            c.y0 < base - tallest - deep)
          continue;
        written[i] = grows = true;
        x0 = std::min(x0, c.x0);
        x1 = std::max(x1, c.x1);
      }
    }
  }
  return written;
}

}  // namespace firn::vision
