#include "core/motion/curve/given_curves.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

constexpr double kMostParts = 64.0;  ///< of a chord

double squared_length(Point2 p) { return p.x_mm * p.x_mm + p.y_mm * p.y_mm; }

/// Number of chords with the sagitta kGivenSagittaMm instead of one with this sagitta, which falls with the
/// square of their number.
int parts_for(double sagitta_mm) {
  return int(std::clamp(std::ceil(std::sqrt(sagitta_mm / kGivenSagittaMm)), 1.0, kMostParts));
}

/// Points strictly inside of a chord of an arc: the chord's, moved out to the circle.
void sample_arc(const GivenCurve& arc, Point2 p, Point2 q, std::vector<Point2>& out) {
  const double radius = distance(arc.centre, p), chord = distance(p, q);
  const int parts = parts_for(chord * chord / (8.0 * radius));
  for (int k = 1; k < parts; ++k) {
    const double x = double(k) / parts;
    const Point2 off{p.x_mm + x * (q.x_mm - p.x_mm) - arc.centre.x_mm,
                     p.y_mm + x * (q.y_mm - p.y_mm) - arc.centre.y_mm};
    const double scale = radius / std::sqrt(squared_length(off));
    out.push_back({arc.centre.x_mm + scale * off.x_mm, arc.centre.y_mm + scale * off.y_mm});
  }
}

/// The same of a Bezier curve between two parameters: a chord is off by at most |r''| (to - from)^2 / 8.
void sample_bezier(const GivenCurve& b, double from, double to, std::vector<Point2>& out) {
  const auto bend = [](Point2 p, Point2 q, Point2 r) {
    return 6.0 * std::sqrt(squared_length({p.x_mm - 2.0 * q.x_mm + r.x_mm, p.y_mm - 2.0 * q.y_mm + r.y_mm}));
  };
  const double most =
      std::max(bend(b.start, b.control[0], b.control[1]), bend(b.control[0], b.control[1], b.end));
  const int parts = parts_for(most * (to - from) * (to - from) / 8.0);
  for (int k = 1; k < parts; ++k) out.push_back(b.at(from + (to - from) * double(k) / parts));
}

}  // namespace

void given_between(std::span<const GivenCurve> given, std::size_t from, std::size_t to,
                   std::vector<GivenCurve>& out) {
  out.clear();
  for (const GivenCurve& whole : given) {
    if (whole.last <= from || whole.first >= to) continue;
    GivenCurve part = whole;
    part.first = std::max(whole.first, from) - from;
    part.last = std::min(whole.last, to) - from;
    const double step = (whole.to - whole.from) / double(whole.last - whole.first);
    part.from = whole.from + step * double(part.first + from - whole.first);
    part.to = whole.from + step * double(part.last + from - whole.first);
    out.push_back(part);
  }
}

std::span<const Point2> sample_given(std::span<const Point2> points, std::span<const GivenCurve> given,
                                     std::vector<Point2>& out) {
  if (given.empty()) return points;
  out.clear();
  std::size_t k = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.push_back(points[i]);
    while (k < given.size() && given[k].last <= i) ++k;
    if (k == given.size() || given[k].first > i) continue;
    const GivenCurve& curve = given[k];
    const double step = (curve.to - curve.from) / double(curve.last - curve.first);
    if (curve.kind == GivenCurve::Kind::kArc)
      sample_arc(curve, points[i], points[i + 1], out);
    else
      sample_bezier(curve, curve.from + step * double(i - curve.first),
                    curve.from + step * double(i + 1 - curve.first), out);
  }
  return out;
}

}  // namespace firn::motion
