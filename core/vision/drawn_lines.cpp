#include "core/vision/drawn_lines.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "core/vision/raster.h"

namespace firn::vision {
namespace {

constexpr double kWhole = 0.97, kHalfWay = 0.5;  // length of a line over the picture's side
constexpr int kBreak_px = 3;                     // gaps that compression makes in a line
constexpr int kMostThickness(int side) { return std::max(4, side / 150); }

// A mask seen by rows or by columns.
struct MaskView {
  CellMask& mask;
  bool columns;
  int lines() const { return columns ? mask.columns : mask.rows; }
  int length() const { return columns ? mask.rows : mask.columns; }
  std::uint8_t& at(int line, int place) const {
    return mask.cells[columns ? mask.index(line, place) : mask.index(place, line)];
  }
};

struct Stretch {
  int first = 0, last = 0;  // lines
  int from = 0, to = -1;    // places along them
};

Stretch longest_run(const MaskView& m, int line) {
  Stretch best{line, line};
  for (int p = 0; p < m.length();) {
    if (!m.at(line, p)) {
      ++p;
      continue;
    }
    const int from = p;
    int to = p;
    for (int gap = 0; p < m.length() && gap <= kBreak_px; ++p) {
      gap = m.at(line, p) ? 0 : gap + 1;
      if (gap == 0) to = p;
    }
    if (to - from > best.to - best.from) {
      best.from = from;
      best.to = to;
    }
  }
  return best;
}

// Bands of lines that are thin and long.
std::vector<Stretch> long_bands(const MaskView& m, int side, int thickness) {
  std::vector<Stretch> bands;
  const auto is_long = [&](const Stretch& s) { return s.to - s.from + 1 >= kHalfWay * side; };
  for (int line = 0; line < m.lines();) {
    Stretch band = longest_run(m, line++);
    if (!is_long(band)) continue;
    for (; line < m.lines(); ++line) {
      const Stretch next = longest_run(m, line);
      if (!is_long(next)) break;
      band.last = line;
      band.from = std::min(band.from, next.from);
      band.to = std::max(band.to, next.to);
    }
    if (band.last - band.first < thickness) bands.push_back(band);
  }
  return bands;
}

bool is_drawn(const Stretch& s, const std::vector<Stretch>& all, int side) {
  if (s.to - s.from + 1 >= kWhole * side) return true;
  const int alike = std::max(3, side / 50);
  return std::ranges::any_of(all, [&](const Stretch& o) {
    return o.first != s.first && std::abs(o.from - s.from) <= alike && std::abs(o.to - s.to) <= alike;
  });
}

// @returns whether a pixel was erased
bool erase(const MaskView& m, const Stretch& s) {
  bool erased = false;
  for (int p = std::max(0, s.from - 1); p <= std::min(m.length() - 1, s.to + 1); ++p) {
    const bool crossed = s.first > 0 && s.last + 1 < m.lines() && m.at(s.first - 1, p) && m.at(s.last + 1, p);
    if (crossed) continue;
    for (int line = s.first; line <= s.last; ++line) erased |= std::exchange(m.at(line, p), 0) != 0;
  }
  return erased;
}

CellMask mask_of(const Component& c) {
  CellMask mask(c.x1 - c.x0 + 1, c.y1 - c.y0 + 1);
  for (const Run& r : c.runs)
    std::fill_n(mask.cells.begin() + std::ptrdiff_t(mask.index(r.x0 - c.x0, r.y - c.y0)), r.x1 - r.x0 + 1,
                std::uint8_t(1));
  return mask;
}

// All four sides of its box are lines, and nothing else.
bool is_box(const Component& c) {
  const int w = c.x1 - c.x0 + 1, h = c.y1 - c.y0 + 1;
  if (w < 24 || h < 24 || c.area > 0.3 * w * h) return false;
  CellMask mask = mask_of(c);
  const int near = std::max(1, std::min(w, h) / 24);
  for (const bool columns : {false, true}) {
    const MaskView m{mask, columns};
    int before = 0, after = 0;
    for (int line = 0; line <= near; ++line) {
      const Stretch a = longest_run(m, line), b = longest_run(m, m.lines() - 1 - line);
      before = std::max(before, a.to - a.from + 1);
      after = std::max(after, b.to - b.from + 1);
    }
    if (std::min(before, after) < 0.95 * m.length()) return false;
  }
  return true;
}

}  // namespace

std::vector<Component> remove_drawn_lines(std::vector<Component>&& components, const Frame& f) {
  std::vector<Component> kept;
  kept.reserve(components.size());
  for (Component& c : components) {
    const bool wide = c.x1 - c.x0 + 1 >= kHalfWay * f.width, high = c.y1 - c.y0 + 1 >= kHalfWay * f.height;
    if (!wide && !high) {
      kept.push_back(std::move(c));
      continue;
    }
    CellMask mask = mask_of(c);
    bool erased = false;
    const MaskView rows{mask, false}, columns{mask, true};
    const std::vector<Stretch> across =
        wide ? long_bands(rows, f.width, kMostThickness(f.height)) : std::vector<Stretch>{};
    const std::vector<Stretch> down =
        high ? long_bands(columns, f.height, kMostThickness(f.width)) : std::vector<Stretch>{};
    for (const Stretch& s : across)
      if (is_drawn(s, across, f.width)) erased |= erase(rows, s);
    for (const Stretch& s : down)
      if (is_drawn(s, down, f.height)) erased |= erase(columns, s);
    if (!erased) {
      kept.push_back(std::move(c));
      continue;
    }
    std::ranges::move(components_of(mask, c.x0, c.y0), std::back_inserter(kept));
  }
  std::erase_if(kept, is_box);
  for (Component& c : kept) c.at_edge = c.x0 == 0 || c.y0 == 0 || c.x1 == f.width - 1 || c.y1 == f.height - 1;
  return kept;
}

}  // namespace firn::vision
