#include "core/vision/nozzle.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/statistics/median.h"

namespace firn::vision {
namespace {

// Rows run along the nozzle's side of the picture and count inwards. Values without another reason were
// chosen on rendered pictures (tests/bench/droplet_pictures.cpp, seeds below 50,000).
constexpr double kHalf = 0.5;                          // opacity of the nozzle's outline
constexpr double kWidthStd_px = 0.12;                  // the halfway level's, which all rows share
constexpr double kReach_px = 2.0, kReachShare = 0.02;  // of a flank, from row to row; share of the width
constexpr int kMinRows = 4;                            // of a nozzle
constexpr long kMinTouch_px = 4;                       // of the picture's side
constexpr int kClearRows = 2;                          // at the edge: its rounding
constexpr int kMinWidthRows = 6, kWidthPart = 3;       // rows of the width: 1 / 3 of the nozzle's, at least 6
constexpr std::size_t kMinUsedRows = 3;                // else all rows are used
constexpr double kCornerShare = 0.08;                  // of the width at either corner: rounded
constexpr double kLiquidShare = 0.22;                  // of the width about the middle: liquid hangs there
constexpr int kEdgeRows = 2;                           // beyond the last row from which the edge is sought
constexpr std::size_t kMinEdges = 2;                   // columns
constexpr double kMinEdgeStd_px = 0.05;
constexpr double kMedianStd = 1.25;  // standard deviation of a median over that of a mean

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
// Dirt over the flank is far from it and is passed over.
class Flank {
 public:
  Flank(double at, double reach_px, bool left) : at_(at), reach_px_(reach_px), left_(left) {}

  double at() const { return seen_at_; }  ///< in the last row
  double expected() const { return at_ + slope_; }
  bool follow(const Turned& t, int s) {
    at_ += slope_;
    ++rows_;
    std::optional<double> best;
    // The first rows set its slope.
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
    // Place and slope follow slowly: dirt that touches the flank must not lead it away.
    const bool first = s < kFirstRows;
    if (rows_ <= kSlopeRows) slope_ += (first ? kFirstSlope : kSlope) * (*best - at_) / rows_;
    at_ += (first ? 1.0 : kGain) * (*best - at_);
    rows_ = 0;
    return true;
  }

 private:
  static constexpr int kFirstRows = 6;  // follow fully and set the slope
  static constexpr int kSlopeRows = 3;  // unseen ones after which the slope stays as it is
  static constexpr double kFirstSlope = 0.5, kSlope = 0.05,
                          kGain = 0.3;                            // shares of the distance that are taken
  static constexpr double kNear_px = 1.5, kNearPerRow_px = 0.05;  // search; more by each unseen row
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

// The side of the picture that the component touches over the longest stretch; it enters from there.
struct Entry {
  int side = 0;
  long touch_px = 0;
};

Entry entry_of(const Component& c, const Frame& f) {
  long touch[4] = {0, 0, 0, 0};
  for (const Run& r : c.runs) {
    if (r.y == 0) touch[0] += r.x1 - r.x0 + 1;
    if (r.y == f.height - 1) touch[1] += r.x1 - r.x0 + 1;
    touch[2] += r.x0 == 0;
    touch[3] += r.x1 == f.width - 1;
  }
  const int side = int(std::max_element(touch, touch + 4) - touch);
  return {side, touch[side]};
}

// Widths and flanks of the rows from `first` on that are clear of the edge and of the picture's other sides.
struct Rows {
  std::vector<double> width, left, right;
};

Rows rows_from(int first, const std::vector<Span>& spans, int breadth) {
  Rows rows;
  for (int s = std::max(0, first); s < int(spans.size()) - kClearRows; ++s) {
    const Span& span = spans[std::size_t(s)];
    if (!span.seen || span.from <= 0 || span.to >= breadth - 1) continue;
    rows.width.push_back(span.width());
    rows.left.push_back(span.from);
    rows.right.push_back(span.to);
  }
  return rows;
}

// The row at which each column of the edge becomes bright, between rounded corners and hanging liquid.
std::vector<double> edge_rows(const Turned& t, int end, double from, double to, double width) {
  std::vector<double> edges;
  for (int k = int(std::ceil(from + kCornerShare * width)); k <= int(to - kCornerShare * width); ++k) {
    const double across = std::abs(double(k) - 0.5 * (from + to)) / width;
    if (across < kLiquidShare) continue;
    int s = std::min(end + kEdgeRows, t.depth - 1);
    if (t.opacity(k, s) >= kHalf) continue;
    while (s > 0 && t.opacity(k, s) < kHalf) --s;
    const double in = t.opacity(k, s), out = t.opacity(k, s + 1);
    if (in > out) edges.push_back(s + (in - kHalf) / (in - out));
  }
  return edges;
}

}  // namespace

Nozzle measure_nozzle(const Scene& scene, const Component& c) {
  Nozzle nozzle;
  const Frame& f = scene.frame();
  const auto [side, touch_px] = entry_of(c, f);
  const Turned t(scene, side);
  const int c0 = side < 2 ? c.x0 : c.y0, c1 = side < 2 ? c.x1 : c.y1;
  const int far = side == 0 ? c.y1 : side == 1 ? f.height - 1 - c.y0 : side == 2 ? c.x1 : f.width - 1 - c.x0;
  const std::vector<Span> spans = follow_flanks(t, far, c0, c1);
  const int end = int(spans.size());
  if (end < kMinRows || touch_px < kMinTouch_px) return nozzle;
  Rows rows = rows_from(end - kClearRows - 1 - std::max(kMinWidthRows, end / kWidthPart), spans, t.breadth);
  if (rows.width.size() < kMinUsedRows) rows = rows_from(0, spans, t.breadth);  // dirt near the edge
  if (rows.width.size() < kMinUsedRows) return nozzle;
  const double width = statistics::median(rows.width), from = statistics::median(rows.left),
               to = statistics::median(rows.right);
  std::vector<double> edges = edge_rows(t, end, from, to, width);
  if (edges.size() < kMinEdges) return nozzle;
  const double edge = statistics::median(edges), middle = 0.5 * (from + to);
  nozzle.found = true;
  nozzle.edge = t.pixel(middle, edge);
  const Point inner = t.pixel(middle, edge + 1);
  nozzle.flight = {inner.x - nozzle.edge.x, inner.y - nozzle.edge.y};
  nozzle.edge_std_px =
      std::max(kMinEdgeStd_px, deviation(edges, edge) / std::sqrt(double(edges.size())) * kMedianStd);
  nozzle.width_px = width;
  nozzle.width_std_px =
      std::sqrt(kWidthStd_px * kWidthStd_px +
                square(kMedianStd * deviation(rows.width, width)) / double(rows.width.size()));
  return nozzle;
}

}  // namespace firn::vision
