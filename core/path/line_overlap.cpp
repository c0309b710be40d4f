#include "core/path/line_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/path/polyline.h"

namespace firn {
namespace {

constexpr double kMinOverlap_mm = 1.0, kMinOverlapShare = 0.5;
constexpr std::size_t kMaxRemarks = 3;

struct SegmentBox {
  double low[2], high[2];
};

SegmentBox box_of(const PrintSegment& s) {
  return {{std::min(s.from.x_mm, s.to.x_mm), std::min(s.from.y_mm, s.to.y_mm)},
          {std::max(s.from.x_mm, s.to.x_mm), std::max(s.from.y_mm, s.to.y_mm)}};
}

/// Part of a stretch [low, high] of parameters on which low_value <= a + b t <= high_value.
struct ParameterRange {
  double low = 0.0, high = 1.0;
  void keep(double a, double b, double low_value, double high_value) {
    if (std::abs(b) < 1e-15) {
      if (a < low_value || a > high_value) high = low;
      return;
    }
    const double t0 = (low_value - a) / b, t1 = (high_value - a) / b;
    low = std::max(low, std::min(t0, t1));
    high = std::min(high, std::max(t0, t1));
  }
};

// Length of the part of `b` that lies within kSameLine_mm of `a`.
double overlap_mm(const PrintSegment& a, const PrintSegment& b) {
  const double length_a = distance(a.from, a.to), length_b = distance(b.from, b.to);
  const double ux = (a.to.x_mm - a.from.x_mm) / length_a, uy = (a.to.y_mm - a.from.y_mm) / length_a;
  const double x0 = b.from.x_mm - a.from.x_mm, y0 = b.from.y_mm - a.from.y_mm;
  const double dx = b.to.x_mm - b.from.x_mm, dy = b.to.y_mm - b.from.y_mm;
  ParameterRange t;
  t.keep(ux * x0 + uy * y0, ux * dx + uy * dy, 0.0, length_a);
  t.keep(ux * y0 - uy * x0, ux * dy - uy * dx, -kSameLine_mm, kSameLine_mm);
  return std::max(0.0, t.high - t.low) * length_b;
}

}  // namespace

std::vector<LineOverlap> line_overlaps(const PrintJob& job) {
  const std::size_t n = job.segments.size();
  std::vector<SegmentBox> boxes;
  double extent[2] = {0.0, 0.0};
  for (const PrintSegment& s : job.segments) {
    boxes.push_back(box_of(s));
    for (int k = 0; k < 2; ++k) extent[k] += boxes.back().high[k] - boxes.back().low[k];
  }
  // A sweep along the axis on which the segments are short compares few pairs.
  const int along = extent[0] <= extent[1] ? 0 : 1, across = 1 - along;
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return boxes[a].low[along] < boxes[b].low[along]; });
  std::vector<LineOverlap> found;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t m = k + 1; m < n; ++m) {
      const SegmentBox &a = boxes[order[k]], &b = boxes[order[m]];
      if (b.low[along] > a.high[along] + kSameLine_mm) break;
      if (b.low[across] > a.high[across] + kSameLine_mm || a.low[across] > b.high[across] + kSameLine_mm)
        continue;
      const auto [first, second] = std::minmax(order[k], order[m]);
      const PrintSegment &s = job.segments[first], &t = job.segments[second];
      const double length_mm = overlap_mm(s, t),
                   shorter_mm = std::min(distance(s.from, s.to), distance(t.from, t.to));
      if (length_mm < std::min(kMinOverlap_mm, kMinOverlapShare * shorter_mm)) continue;
      found.push_back({std::int32_t(first), std::int32_t(second), length_mm});
    }
  std::sort(found.begin(), found.end(), [](const LineOverlap& a, const LineOverlap& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  });
  return found;
}

std::vector<std::string> overlap_remarks(const PrintJob& job) {
  const std::vector<LineOverlap> all = line_overlaps(job);
  std::vector<std::string> remarks;
  for (const LineOverlap& o : all) {
    if (remarks.size() == kMaxRemarks) break;
    char text[200];
    std::snprintf(
        text, sizeof text,
        "segments[%d] lies on segments[%d] along %.6g mm: the ink of both is there, and is measured "
        "against that of one line",
        int(o.second), int(o.first), o.length_mm);
    remarks.emplace_back(text);
  }
  if (all.size() > remarks.size())
    remarks.push_back(std::to_string(all.size() - remarks.size()) +
                      " more pairs of segments lie on each other");
  return remarks;
}

}  // namespace firn
