#include "core/geometry/minimum_link.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/ring_writer.h"

namespace firn::geometry {
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

bool MinimumLinkSimplifier::operator()(std::span<const Vec> line, double tolerance, Rings& rings,
                                       std::span<const std::size_t> fixed) {
  RingWriter out(rings, 2 * line.size() + 2 * fixed.size() + 2);
  const auto drawn = [&](ToleranceTube::Width width) {
    out.clear();
    std::size_t from = 0;
    for (const std::size_t to : fixed) {
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
  // Edges along a smooth bend touch the tube on its inner side and end at the outer one: they lie a third of
  // the tolerance too far inside. Where that does not cancel over the ring, a tube of up to half the width on
  // the inner side corrects it.
  const double to_left = (twice_area(line) - area) / (2 * length(out.ring()));
  const double width = std::max(0.5, 1 - 1.5 * std::abs(to_left) / tolerance) * tolerance;
  if (to_left > kOneSided * tolerance) return drawn({width, tolerance}) != 0;
  if (to_left < -kOneSided * tolerance) return drawn({tolerance, width}) != 0;
  return true;
}

// Draws from the first point of `line` past the others to `behind`, which the next call draws.
void MinimumLinkSimplifier::draw(std::span<const Vec> line, Vec behind, ToleranceTube::Width width,
                                 RingWriter& out) {
  const std::size_t n = line.size();
  out.add(line[0]);
  if (n == 1) return;
  const auto place = [&](std::size_t i) { return i < n ? line[i] : behind; };
  const auto allowed = [&](std::size_t i) { return i < n ? width : ToleranceTube::Width{0, 0}; };
  // Cross-sections are perpendicular to the direction of the next vertex that is not close to the anchor.
  const double near = kAhead * std::max(width.left, width.right);
  const auto ahead = [&](Vec from, std::size_t i) {
    for (; i < n; ++i)
      if (const Vec way = line[i] - from; dot(way, way) >= near * near) break;
    return place(i);
  };
  ToleranceTube::Window window;
  bool open = false;  // the corner before the present edge may lie anywhere in the window
  const auto end_at = [&](const ToleranceTube::Line& edge) {
    if (open) out.add(window.crossing(edge));
    open = false;
  };
  tube_.reserve(n);
  tube_.begin(line[0], ahead(line[0], 1));
  for (std::size_t i = 1, first = 1; i <= n;) {
    ToleranceTube::Turn turn = tube_.take(line, i, width);
    if (turn == ToleranceTube::Turn::kNone) {
      std::size_t closing = 0;
      turn = tube_.take(std::span(&behind, 1), closing, {0, 0});
      if (turn == ToleranceTube::Turn::kNone) break;
    }
    Vec anchor;
    if (i == first) {
      if (open) out.add(window.far_end());
      open = false;
      anchor = place(i++);
    } else {
      ToleranceTube::Window next;
      if (!tube_.spans_last_section() && tube_.window(turn, place(i), allowed(i), next) &&
          tube_.pass_on(turn, next, ahead(next.far_end(), i), place(i))) {
        end_at(next.line);
        window = next;
        open = true;
        first = i;
        continue;
      }
      const ToleranceTube::End end = tube_.end();
      end_at(end.line);
      anchor = end.at;
    }
    out.add(anchor);
    first = i;
    tube_.begin(anchor, ahead(anchor, i));
  }
  end_at(tube_.end().line);
}

}  // namespace firn::geometry
