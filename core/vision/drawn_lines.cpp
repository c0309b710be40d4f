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
constexpr int kMostCut = 4;                      // gap that a bright line leaves in an object [px]
constexpr int kLeastFace = 8, kDeep = 3;         // sides of such a gap [px]
constexpr long kLeastPart = 64;                  // area [px]
constexpr int most_thickness_px(int side) { return std::max(4, side / 150); }

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

struct Cover {
  int from = 0, to = -1, cells = 0;
  int width() const { return to - from + 1; }
};

Cover cover_of(const MaskView& m, int line) {
  Cover c;
  for (int p = 0; p < m.length(); ++p)
    if (m.at(line, p)) {
      if (c.cells++ == 0) c.from = p;
      c.to = p;
    }
  return c;
}

// The last lines of an object at a cut, from its first or last line, in places of the picture.
struct Face {
  bool flat = false;
  int from = 0, to = -1;
};

Face face_of(const Component& c, bool columns, bool at_first) {
  CellMask mask = mask_of(c);
  const MaskView m{mask, columns};
  Face f;
  if (m.lines() <= kDeep) return f;
  const Cover edge = cover_of(m, at_first ? 0 : m.lines() - 1),
              inner = cover_of(m, at_first ? kDeep : m.lines() - 1 - kDeep);
  const int begin = columns ? c.y0 : c.x0;
  f.flat = edge.width() >= kLeastFace && edge.cells >= 0.8 * inner.cells && inner.cells >= 0.8 * edge.cells;
  f.from = begin + edge.from;
  f.to = begin + edge.to;
  return f;
}

// A bright line cuts an object into two that face each other with flat, equal sides; droplets are round.
bool is_cut(const Component& a, const Component& b, bool columns) {
  const int gap = columns ? b.x0 - a.x1 - 1 : b.y0 - a.y1 - 1;
  if (gap < 1 || gap > kMostCut || std::min(a.area, b.area) < kLeastPart) return false;
  const Face f = face_of(a, columns, false), g = face_of(b, columns, true);
  const int shared = std::min(f.to, g.to) - std::max(f.from, g.from) + 1,
            widest = std::max(f.to - f.from, g.to - g.from) + 1;
  return f.flat && g.flat && shared >= 0.8 * widest;
}

void append(Component& a, Component&& b) {
  a.x0 = std::min(a.x0, b.x0);
  a.y0 = std::min(a.y0, b.y0);
  a.x1 = std::max(a.x1, b.x1);
  a.y1 = std::max(a.y1, b.y1);
  a.area += b.area;
  a.at_edge |= b.at_edge;
  std::vector<Run> runs;
  std::ranges::merge(a.runs, b.runs, std::back_inserter(runs),
                     [](const Run& p, const Run& q) { return p.y != q.y ? p.y < q.y : p.x0 < q.x0; });
  a.runs = std::move(runs);
}

// Joins an object at the picture's edge and the objects that a line cuts off from it.
void join_cut_objects(std::vector<Component>& components) {
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (components[i].area < kLeastPart) continue;
    for (std::size_t k = 0; k < components.size() && components[i].at_edge; ++k) {
      const Component &a = components[i], &b = components[k];
      if (b.at_edge ||
          !(is_cut(a, b, false) || is_cut(b, a, false) || is_cut(a, b, true) || is_cut(b, a, true)))
        continue;
      append(components[i], std::move(components[k]));
      components.erase(components.begin() + std::ptrdiff_t(k));
      if (k < i) --i;
      k = std::size_t(-1);  // again: there may be a second cut
    }
  }
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
        wide ? long_bands(rows, f.width, most_thickness_px(f.height)) : std::vector<Stretch>{};
    const std::vector<Stretch> down =
        high ? long_bands(columns, f.height, most_thickness_px(f.width)) : std::vector<Stretch>{};
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
  join_cut_objects(kept);
  return kept;
}

}  // namespace firn::vision
