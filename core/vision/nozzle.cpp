#include "core/vision/nozzle.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/statistics/median.h"

namespace firn::vision {
namespace {

constexpr double kHalf = 0.5;
constexpr double kWidthStd_px = 0.12;                  // the halfway level's, which all rows share
constexpr double kReach_px = 2.0, kReachShare = 0.02;  // of a flank, from row to row; share of the width

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
  bool seen = false;  // both sides
  double width() const { return to - from; }
};

// The halfway point between columns c - 1 and c of a row, where it is crossed.
std::optional<double> halfway(const Turned& t, int s, int c) {
  const double a = t.opacity(c - 1, s), b = t.opacity(c, s);
  if ((a < kHalf) == (b < kHalf)) return std::nullopt;
  return c - 1 + (kHalf - a) / (b - a);
}

// One flank of the nozzle, followed from row to row: the halfway point nearest to where the rows before lead.
// Writing over the flank is far from it and is passed over.
class Flank {
 public:
  Flank(double at, double reach_px, bool left) : at_(at), reach_px_(reach_px), left_(left) {}

  double at() const { return seen_at_; }  ///< in the last row
  double expected() const { return at_ + slope_; }
  bool follow(const Turned& t, int s) {
    at_ += slope_;
    ++rows_;
    std::optional<double> best;
    // Its first rows, where nothing is written, say how it runs.
    const double near = s < kFirstRows ? reach_px_ : std::min(reach_px_, kNear_px + kNearPerRow_px * rows_);
    const int middle = int(std::lround(at_)), reach = int(std::ceil(near)) + 1;
    for (int c = std::max(1, middle - reach); c <= std::min(t.breadth - 1, middle + reach); ++c) {
      if ((t.opacity(c, s) >= kHalf) != left_) continue;
      const auto at = halfway(t, s, c);
      if (at && std::abs(*at - at_) <= near && (!best || std::abs(*at - at_) < std::abs(*best - at_)))
        best = at;
    }
    seen_at_ = best.value_or(at_);
    if (!best) return false;
    // Place and slope follow slowly: writing that touches the flank must not lead it away.
    const bool first = s < kFirstRows;
    if (rows_ <= kSlopeRows) slope_ += (first ? kFirstSlope : kSlope) * (*best - at_) / rows_;
    at_ += (first ? 1.0 : kGain) * (*best - at_);
    rows_ = 0;
    return true;
  }

 private:
  static constexpr int kSlopeRows = 3, kFirstRows = 6;
  static constexpr double kSlope = 0.05, kFirstSlope = 0.5, kGain = 0.3;
  static constexpr double kNear_px = 1.5, kNearPerRow_px = 0.05;
  double at_, reach_px_, slope_ = 0.0, seen_at_ = 0.0;
  bool left_;
  int rows_ = 0;  // since it was seen
};

// The longest stretch of a row that is the nozzle's.
Span longest_run(const Turned& t, int s, int c0, int c1) {
  Span longest;
  for (int c = c0; c <= c1; ++c) {
    if (t.opacity(c, s) < kHalf) continue;
    int last = c;
    while (last < c1 && t.opacity(last + 1, s) >= kHalf) ++last;
    if (last - c > longest.width()) {
      longest = {double(c), double(last), true};
      if (c > 0) longest.from = halfway(t, s, c).value_or(c);
      if (last + 1 < t.breadth) longest.to = halfway(t, s, last + 1).value_or(last);
    }
    c = last;
  }
  return longest;
}

// Share of the stretch that is not bright.
double covered(const Turned& t, int s, double from, double to) {
  int n = 0, dark = 0;
  for (int c = std::max(0, int(std::ceil(from))); c <= std::min(t.breadth - 1, int(to)); ++c, ++n)
    dark += t.opacity(c, s) >= kHalf;
  return n > 0 ? double(dark) / n : 0.0;
}

// The rows of the nozzle from the picture's edge to its own.
std::vector<Span> follow_flanks(const Turned& t, int far, int c0, int c1) {
  std::vector<Span> spans;
  const Span first = longest_run(t, 0, c0, c1);
  if (!first.seen) return spans;
  const double reach = kReach_px + kReachShare * first.width();
  Flank left(first.from, reach, true), right(first.to, reach, false);
  for (int s = 0; s <= far; ++s) {
    const double from = left.expected(), to = right.expected();
    if (s > 2 && covered(t, s, from, to) < kHalf) break;
    const bool left_seen = left.follow(t, s), right_seen = right.follow(t, s);
    spans.push_back({left.at(), right.at(), left_seen && right_seen});
  }
  return spans;
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
  const std::vector<Span> spans = follow_flanks(t, far, c0, c1);
  const int end = int(spans.size());
  if (end < 4 || touch[side] < 4) return nozzle;
  // Rows close to the edge, but clear of its rounding.
  std::vector<double> near, left, right;
  const auto take = [&](int from) {
    near.clear();
    left.clear();
    right.clear();
    for (int s = std::max(0, from); s < end - 2; ++s) {
      const Span& span = spans[std::size_t(s)];
      if (!span.seen || span.from <= 0 || span.to >= t.breadth - 1) continue;
      near.push_back(span.width());
      left.push_back(span.from);
      right.push_back(span.to);
    }
  };
  take(end - 3 - std::max(6, end / 3));
  if (near.size() < 3) take(0);  // written over
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
