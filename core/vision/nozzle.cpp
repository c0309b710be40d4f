#include "core/vision/nozzle.h"

#include <algorithm>
#include <cmath>

#include "core/statistics/median.h"

namespace firn::vision {
namespace {

constexpr double kHalf = 0.5;
constexpr double kWidthStd_px = 0.12;  // the halfway level's, which all rows share

// The picture seen with the nozzle at the top: s counts inwards from the nozzle's side, c along that side.
struct Turned {
  const Scene& scene;
  int side;  // 0 top, 1 bottom, 2 left, 3 right
  int depth, breadth;

  Turned(const Scene& sc, int s) : scene(sc), side(s) {
    const Frame& f = sc.frame();
    depth = s < 2 ? f.height : f.width;
    breadth = s < 2 ? f.width : f.height;
  }
  Point pixel(double c, double s) const {
    if (side == 0) return {c, s};
    if (side == 1) return {c, depth - 1 - s};
    if (side == 2) return {s, c};
    return {depth - 1 - s, c};
  }
  double opacity(int c, int s) const {
    const Point p = pixel(c, s);
    return scene.opacity(int(p.x), int(p.y));
  }
};

struct Span {
  double from = 0.0, to = 0.0;
  bool seen = false;
  double width() const { return to - from; }
};

// The outermost halfway points of one row, within the component's columns.
Span span_of(const Turned& t, int s, int c0, int c1) {
  Span span;
  int first = c0, last = c1;
  while (first <= last && t.opacity(first, s) < kHalf) ++first;
  while (last >= first && t.opacity(last, s) < kHalf) --last;
  if (first > last) return span;
  span = {double(first), double(last), true};
  if (first > 0) {
    const double in = t.opacity(first, s), out = t.opacity(first - 1, s);
    if (in > out && out < kHalf) span.from = first - (in - kHalf) / (in - out);
  }
  if (last + 1 < t.breadth) {
    const double in = t.opacity(last, s), out = t.opacity(last + 1, s);
    if (in > out && out < kHalf) span.to = last + (in - kHalf) / (in - out);
  }
  return span;
}

double square(double x) { return x * x; }

double deviation(std::vector<double> v, double middle) {
  for (double& x : v) x = std::abs(x - middle);
  return statistics::kMadToStd * statistics::median(v);
}

}  // namespace

Nozzle measure_nozzle(const Scene& scene, const Component& c) {
  Nozzle nozzle;
  const Frame& f = scene.frame();
  // The side that the component touches over the longest stretch; it enters from there.
  long touch[4] = {0, 0, 0, 0};
  for (const Run& r : c.runs) {
    if (r.y == 0) touch[0] += r.x1 - r.x0 + 1;
    if (r.y == f.height - 1) touch[1] += r.x1 - r.x0 + 1;
    touch[2] += r.x0 == 0;
    touch[3] += r.x1 == f.width - 1;
  }
  const int side = int(std::max_element(touch, touch + 4) - touch);
  const Turned t(scene, side);
  const int c0 = side < 2 ? c.x0 : c.y0, c1 = side < 2 ? c.x1 : c.y1;
  const int far = side == 0 ? c.y1 : side == 1 ? f.height - 1 - c.y0 : side == 2 ? c.x1 : f.width - 1 - c.x0;
  std::vector<Span> spans;
  std::vector<double> widths;
  int end = -1;
  for (int s = 0; s <= far; ++s) {
    const Span span = span_of(t, s, c0, c1);
    if (widths.size() >= 3) {
      std::vector<double> before(widths.end() - std::ptrdiff_t(std::min<std::size_t>(widths.size(), 24)),
                                 widths.end());
      if (!span.seen || span.width() < kHalf * statistics::median(before)) {
        end = s;
        break;
      }
    }
    spans.push_back(span);
    widths.push_back(span.seen ? span.width() : 0.0);
  }
  if (end < 0) end = far + 1;
  if (end < 4 || touch[side] < 4) return nozzle;
  // Rows close to the edge, but clear of its rounding.
  std::vector<double> near, left, right;
  for (int s = std::max(0, end - 3 - std::max(6, end / 3)); s < end - 2; ++s) {
    const Span& span = spans[std::size_t(s)];
    if (!span.seen || span.from <= 0 || span.to >= t.breadth - 1) continue;
    near.push_back(span.width());
    left.push_back(span.from);
    right.push_back(span.to);
  }
  if (near.size() < 3) return nozzle;
  const double width = statistics::median(near), from = statistics::median(left),
               to = statistics::median(right);
  std::vector<double> edges;
  for (int k = int(std::ceil(from + 0.08 * width)); k <= int(to - 0.08 * width); ++k) {
    const double across = std::abs(double(k) - 0.5 * (from + to)) / width;
    if (across < 0.22) continue;  // liquid hangs from the middle
    int s = std::min(end + 2, t.depth - 1);
    if (t.opacity(k, s) >= kHalf) continue;
    while (s > 0 && t.opacity(k, s) < kHalf) --s;
    const double in = t.opacity(k, s), out = t.opacity(k, s + 1);
    if (in > out) edges.push_back(s + (in - kHalf) / (in - out));
  }
  if (edges.size() < 2) return nozzle;
  const double edge = statistics::median(edges), middle = 0.5 * (from + to);
  nozzle.found = true;
  nozzle.edge = t.pixel(middle, edge);
  const Point inner = t.pixel(middle, edge + 1);
  nozzle.flight = {inner.x - nozzle.edge.x, inner.y - nozzle.edge.y};
  nozzle.edge_std_px = std::max(0.05, deviation(edges, edge) / std::sqrt(double(edges.size())) * 1.25);
  nozzle.width_px = width;
  nozzle.width_std_px =
      std::sqrt(kWidthStd_px * kWidthStd_px + square(1.25 * deviation(near, width)) / double(near.size()));
  return nozzle;
}

}  // namespace firn::vision
