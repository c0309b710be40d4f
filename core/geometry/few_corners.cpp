#include "core/geometry/few_corners.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/ring_writer.h"

namespace firn::slice {
namespace {

constexpr double kAhead = 5;       // tolerances
constexpr double kOneSided = 0.1;  // tolerances

double twice_area(std::span<const Vec> line) {
  double sum = 0;
  for (std::size_t i = 2; i < line.size(); ++i) sum += cross(line[i - 1] - line[0], line[i] - line[0]);
  return sum;
}

double length(std::span<const Point> ring) {
  double sum = 0;
  Vec at = to_vec(ring.back());
  for (const Point p : ring) {
    const Vec next = to_vec(p);
    sum += length(next - at);
    at = next;
  }
  return sum;
}

}  // namespace

bool FewCorners::operator()(std::span<const Vec> line, double tolerance, Rings& rings,
                            std::span<const std::size_t> stay) {
  RingWriter out(rings, 2 * line.size() + 2 * stay.size() + 2);
  const auto drawn = [&](Corridor::Width width) {
    out.clear();
    std::size_t from = 0;
    for (const std::size_t to : stay) {
      if (to > from) draw(line.subspan(from, to - from), line[to], width, out);
      from = to;
    }
    draw(line.subspan(from), line[0], width, out);
    const double area = out.size() >= 3 ? out.close() : 0;
    if (area == 0) out.clear();
    return area;
  };
  const double area = drawn({tolerance, tolerance});
  if (area == 0) return false;
  // Edges of a smooth bend touch the wall on its inner side and end at the other: a third of the tolerance
  // too far in. Where that does not even out over the ring, half the width on the inner side makes it even.
  const double to_left = (twice_area(line) - area) / (2 * length(out.ring()));
  const double width = std::max(0.5, 1 - 1.5 * std::abs(to_left) / tolerance) * tolerance;
  if (to_left > kOneSided * tolerance) return drawn({width, tolerance}) != 0;
  if (to_left < -kOneSided * tolerance) return drawn({tolerance, width}) != 0;
  return true;
}

// From the first of some places, past the others, to the one behind them, which is left to what comes next.
void FewCorners::draw(std::span<const Vec> line, Vec behind, Corridor::Width width, RingWriter& out) {
  const std::size_t n = line.size();
  out.add(line[0]);
  if (n == 1) return;
  const auto place = [&](std::size_t i) { return i < n ? line[i] : behind; };
  const auto allowed = [&](std::size_t i) { return i < n ? width : Corridor::Width{0, 0}; };
  // Gates stand across the way to the next place that is not beside the anchor.
  const double near = kAhead * std::max(width.left, width.right);
  const auto ahead = [&](Vec from, std::size_t i) {
    for (; i < n; ++i)
      if (const Vec way = line[i] - from; dot(way, way) >= near * near) break;
    return place(i);
  };
  Corridor::Window window;
  bool open = false;  // is the corner before the present edge somewhere in the window?
  const auto end_at = [&](const Corridor::Line& edge) {
    if (open) out.add(window.crossing(edge));
    open = false;
  };
  corridor_.reserve(n);
  corridor_.begin(line[0], ahead(line[0], 1));
  for (std::size_t i = 1, first = 1; i <= n;) {
    Corridor::Turn turn = corridor_.take(line, i, width);
    if (turn == Corridor::Turn::kNone) {
      std::size_t closing = 0;
      turn = corridor_.take(std::span(&behind, 1), closing, {0, 0});
      if (turn == Corridor::Turn::kNone) break;
    }
    Vec anchor;
    if (i == first) {
      if (open) out.add(window.far_end());
      open = false;
      anchor = place(i++);
    } else {
      Corridor::Window next;
      if (!corridor_.last_is_whole() && corridor_.window(turn, place(i), allowed(i), next) &&
          corridor_.pass_on(turn, next, ahead(next.far_end(), i), place(i))) {
        end_at(next.line);
        window = next, open = true, first = i;
        continue;
      }
      const Corridor::End end = corridor_.end();
      end_at(end.line);
      anchor = end.at;
    }
    out.add(anchor);
    first = i;
    corridor_.begin(anchor, ahead(anchor, i));
  }
  end_at(corridor_.end().line);
}

}  // namespace firn::slice
