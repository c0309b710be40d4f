#include "core/slice/paths/fill_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/exact/exact_math.h"
#include "core/geometry/planar.h"

namespace firn::slice {
namespace {

// The crossing of a scan line and the outline.
struct Cut {
  std::int64_t line = 0;   // number of the line
  double along = 0;        // position on it
  std::uint32_t edge = 0;  // edge of the outline: index of its first point
  geometry::Vec at;
  bool enters = false;
  std::uint32_t mate = 0;               // other end of the part inside
  std::uint32_t before = 0, after = 0;  // neighbours along the outline
  std::uint32_t ring = 0;
};

// Returns all cuts, along each ring in the direction of the outline.
std::vector<Cut> cuts_of(const geometry::Region& region, double spacing, geometry::Vec along) {
  const geometry::Vec across = left_of(along);
  std::vector<Cut> cuts;
  std::size_t begin = 0;
  for (std::uint32_t r = 0; r < region.size(); ++r) {
    const std::size_t end = region.ends[r], first_cut = cuts.size();
    for (std::size_t i = begin; i < end; ++i) {
      const geometry::Vec a = to_vec(region.points[i]),
                          b = to_vec(region.points[i + 1 < end ? i + 1 : begin]);
      const double ya = dot(a, across) / spacing, yb = dot(b, across) / spacing;
      // Lines with lower <= k < upper: each corner belongs to one of its edges.
      const std::int64_t low = std::int64_t(std::ceil(std::min(ya, yb))),
                         high = std::int64_t(std::ceil(std::max(ya, yb)));
      const bool rises = yb > ya;
      for (std::int64_t step = 0; step < high - low; ++step) {
        const std::int64_t k = rises ? low + step : high - 1 - step;
        const geometry::Vec at = a + std::clamp((double(k) - ya) / (yb - ya), 0.0, 1.0) * (b - a);
        // Material lies left of the outline, which rises on the right of the part inside.
        cuts.push_back({k, dot(at, along), std::uint32_t(i), at, !rises, 0, 0, 0, r});
      }
    }
    for (std::size_t c = first_cut; c < cuts.size(); ++c) {
      cuts[c].before = std::uint32_t(c > first_cut ? c - 1 : cuts.size() - 1);
      cuts[c].after = std::uint32_t(c + 1 < cuts.size() ? c + 1 : first_cut);
    }
    begin = end;
  }
  return cuts;
}

// Pairs the cuts of each line. @return the entering ones, by line and position
std::vector<std::uint32_t> pair_up(std::vector<Cut>& cuts) {
  std::vector<std::uint32_t> order(cuts.size()), entering;
  for (std::uint32_t c = 0; c < cuts.size(); ++c) {
    order[c] = c;
    cuts[c].mate = c;
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (cuts[a].line != cuts[b].line) return cuts[a].line < cuts[b].line;
    return cuts[a].along != cuts[b].along ? cuts[a].along < cuts[b].along : a < b;
  });
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    Cut &a = cuts[order[i]], &b = cuts[order[i + 1]];
    if (a.line != b.line || !a.enters || b.enters) continue;
    a.mate = order[i + 1];
    b.mate = order[i];
    entering.push_back(order[i]);
    ++i;
  }
  return entering;
}

void push(geometry::Rings& lines, std::size_t begin, geometry::Vec v) {
  const geometry::Point p = to_point(v);
  if (lines.points.size() == begin || lines.points.back() != p) lines.points.push_back(p);
}

void finish(geometry::Rings& lines, std::size_t begin) {
  if (lines.points.size() - begin < 2)
    lines.points.resize(begin);
  else
    lines.ends.push_back(std::uint32_t(lines.points.size()));
}

}  // namespace

geometry::Vec direction_at(double angle_rad) {
  constexpr double kSteps = 1 << 30;
  const geometry::Vec v{std::nearbyint(exact::cos(angle_rad) * kSteps),
                        std::nearbyint(exact::sin(angle_rad) * kSteps)};
  return (1 / length(v)) * v;
}

geometry::Rings fill_lines(const geometry::Region& region, double spacing_mm, double angle_rad) {
  std::vector<Cut> cuts = cuts_of(region, spacing_mm * geometry::kUnitsPerMm, direction_at(angle_rad));
  geometry::Rings lines;
  for (const std::uint32_t c : pair_up(cuts)) {
    const std::size_t begin = lines.points.size();
    push(lines, begin, cuts[c].at);
    push(lines, begin, cuts[cuts[c].mate].at);
    finish(lines, begin);
  }
  return lines;
}

geometry::Region swept_by(const geometry::Rings& lines, double half_mm) {
  constexpr int kEnd = 6;  // chords of a round end
  geometry::Vec turn[kEnd + 1];
  for (int i = 0; i <= kEnd; ++i) turn[i] = direction_at(std::numbers::pi * i / kEnd);
  geometry::Rings outlines;
  std::vector<geometry::Point> outline;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    for (std::size_t p = 1; p < lines[l].size(); ++p) {
      const geometry::Vec a = to_vec(lines[l][p - 1]), b = to_vec(lines[l][p]);
      const geometry::Vec across = (half_mm * geometry::kUnitsPerMm / length(b - a)) * left_of(b - a);
      const auto end = [&](geometry::Vec at, geometry::Vec from) {
        for (const geometry::Vec t : turn) outline.push_back(to_point(at + t.x * from + t.y * left_of(from)));
      };
      outline.clear();
      end(b, geometry::Vec{} - across);
      end(a, across);
      outlines.add(outline);
    }
  }
  return region_of(outlines);
}

geometry::Rings fill_zigzag(const geometry::Region& region, double spacing_mm, double angle_rad) {
  std::vector<Cut> cuts = cuts_of(region, spacing_mm * geometry::kUnitsPerMm, direction_at(angle_rad));
  const std::vector<std::uint32_t> entering = pair_up(cuts);
  // Returns the cut to which the outline leads from this one, on the next line of the zigzag; the cut itself
  // if there is no such cut.
  const auto linked = [&](std::uint32_t c, bool& forward) {
    const bool upward = (cuts[c].line % 2 == 0) != cuts[c].enters;  // even lines continue at their far end
    const std::int64_t line = cuts[c].line + (upward ? 1 : -1);
    forward = upward != cuts[c].enters;  // the outline rises at the end of the part
    const std::uint32_t to = forward ? cuts[c].after : cuts[c].before;
    const bool fits = cuts[to].line == line && cuts[to].enters == cuts[c].enters && cuts[to].mate != to;
    return fits ? to : c;
  };
  geometry::Rings lines;
  std::vector<bool> done(cuts.size(), false);
  for (const std::uint32_t start : entering) {
    if (done[start]) continue;
    // Descends to the lowest line of this zigzag, then traces it upward.
    std::uint32_t in = start;
    bool forward = false;
    for (;;) {
      const bool even = cuts[in].line % 2 == 0;
      const std::uint32_t from = cuts[in].enters == even ? in : cuts[in].mate;  // the end that leads downward
      const std::uint32_t to = linked(from, forward);
      if (to == from) {
        in = from;
        break;
      }
      in = to;
    }
    const std::size_t begin = lines.points.size();
    for (std::uint32_t c = in;;) {
      const std::uint32_t out = cuts[c].mate;
      done[c] = done[out] = true;
      push(lines, begin, cuts[c].at);
      push(lines, begin, cuts[out].at);
      const std::uint32_t to = linked(out, forward);
      if (to == out) break;
      // Corners of the outline between the two cuts.
      const std::size_t ring_begin = cuts[out].ring ? region.ends[cuts[out].ring - 1] : 0;
      const std::size_t ring_end = region.ends[cuts[out].ring];
      for (std::uint32_t e = cuts[out].edge; e != cuts[to].edge;) {
        const std::uint32_t next = std::uint32_t(e + 1 < ring_end ? e + 1 : ring_begin);
        const std::uint32_t last = std::uint32_t(e > ring_begin ? e - 1 : ring_end - 1);
        push(lines, begin, to_vec(region.points[forward ? next : e]));
        e = forward ? next : last;
      }
      c = to;
    }
    finish(lines, begin);
  }
  return lines;
}

}  // namespace firn::slice
