#include "core/vision/writing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/vision/raster.h"

namespace firn::vision {
namespace {

constexpr int kLeast_px = 6;           // height of a character that can be told from a spot
constexpr int kMostShare = 7;          // of the picture's height
constexpr double kAlike = 0.2;         // of baselines, share of the height
constexpr double kSmallLetter = 0.55;  // height of small letters over that of capitals, at least
constexpr double kApart = 1.7;         // gap between characters of a line over their height
constexpr double kWords = 2.0;         // gap between words over the height of their characters
constexpr double kBar = 0.6;           // least share of a bar in its box
constexpr double kStroke = 0.78;       // width of a stroke or bowl over the shorter side of its character
constexpr double kSlim = 0.75;         // width over height of digits that are closed, as 0 and 8
constexpr double kClosed = 0.65;       // share of its box that such a digit fills; a droplet with a tail less
constexpr double kSquare = 0.86;       // share of its box that no disc fills: D
constexpr double kDetailed = 2.1;      // sides of its pixels that are its outline, over those of its box
constexpr double kWord = 2.6;          // the same of a whole word: two of them are a line
constexpr int kCoarse_px = 12;         // height below which a disc's pixels may fill more
constexpr int kLeastBar_px = 32;       // of a scale bar's length
constexpr int kBarLength = 6;          // length of a scale bar over its thickness, at least
constexpr std::size_t kLeastLetters = 3;

int height_of(const Component& c) { return c.y1 - c.y0 + 1; }
int width_of(const Component& c) { return c.x1 - c.x0 + 1; }

// Sides of the mask's cells between on and off, over the circumference of the box: 1 of a disc, 1 + s of one
// with a bright middle of the share s, more of characters of several strokes or with an outline of their own.
double outline_share(const Silhouette& s) {
  long sides = 0;
  for (int j = 0; j <= s.rows; ++j)
    for (int i = 0; i <= s.columns; ++i) {
      const bool on = s.at(i, j);
      sides += (on != s.at(i - 1, j)) + (on != s.at(i, j - 1));
    }
  return double(sides) / (2.0 * (s.columns + s.rows));
}

Silhouette silhouette_of(const Component& c) {
  Silhouette s;
  s.columns = width_of(c);
  s.rows = height_of(c);
  s.mask = mask_of(c).cells;
  return s;
}

bool is_word(const Component& c) { return outline_share(silhouette_of(c)) > kWord; }

// Strokes are slim everywhere, droplets with or without a tail are as wide as their box.
bool is_character(const Component& c) {
  Silhouette s = silhouette_of(c);
  if (outline_share(s) > kDetailed) return true;
  fill_holes(s);
  const int w = s.columns, h = s.rows;
  const double radius = std::sqrt(double(std::ranges::max(squared_distances(s))));
  if (2 * radius - 1 < kStroke * std::min(w, h)) return true;
  const double share = 1.0 - double(std::ranges::count(s.mask, 0)) / (double(w) * h);
  return (h >= kCoarse_px && share > kSquare) || (w < kSlim * h && share > kClosed);
}

// A scale bar: level, of one thickness, its ends without or with strokes across; a tail has a head at one
// end.
bool is_scale_bar(const Component& c) {
  const int w = width_of(c), h = height_of(c);
  if (c.at_edge || w < kLeastBar_px || w < kBarLength * h / 2) return false;
  std::vector<int> thickness(static_cast<std::size_t>(w));
  for (const Run& r : c.runs)
    for (int x = r.x0; x <= r.x1; ++x) ++thickness[std::size_t(x - c.x0)];
  const auto middle_from = thickness.begin() + w / 6, middle_to = thickness.end() - w / 6;
  const auto [least, most] = std::minmax_element(middle_from, middle_to);
  const auto left = std::max_element(thickness.begin(), middle_from),
             right = std::max_element(thickness.rbegin(), thickness.rbegin() + w / 6).base() - 1;
  const int near_end = std::max(3, h / 5);
  return *most - *least <= 1 && *least > 0 && w >= kBarLength * *most && std::abs(*left - *right) <= 2 &&
         left - thickness.begin() <= near_end && thickness.end() - 1 - right <= near_end;
}

bool side_by_side(const Component& a, const Component& b) {
  const int h = std::max(height_of(a), height_of(b)), alike = std::max(1, int(kAlike * h));
  return std::min(height_of(a), height_of(b)) >= kSmallLetter * h && std::abs(a.y1 - b.y1) <= alike &&
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
  for (const std::size_t i : order) written[i] = written[i] || is_scale_bar(components[i]);
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
    const auto counts = [&](std::size_t i) { return is_word(components[i]); };
    if (line.size() < kLeastLetters && (line.size() < 2 || !std::ranges::all_of(line, counts))) continue;
    const auto sure = std::ranges::count_if(line, [&](std::size_t i) { return is_character(components[i]); });
    if (2 * sure < std::ptrdiff_t(line.size())) continue;
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
