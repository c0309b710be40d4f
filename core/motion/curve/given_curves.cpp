#include "core/motion/curve/given_curves.h"

#include <algorithm>
#include <cmath>

namespace firn::motion {
namespace {

double squared_length(Point2 p) { return p.x_mm * p.x_mm + p.y_mm * p.y_mm; }

/// Number of chords with the sagitta kGivenSagittaMm instead of one with this sagitta, which falls with the
/// square of their number.
int parts_for(double sagitta_mm) {
  return int(std::clamp(std::ceil(std::sqrt(sagitta_mm / kGivenSagittaMm)), 1.0, kMaxGivenChords));
}

/// Points strictly inside of a chord of an arc: the chord's, moved out to the circle. Returns the largest
/// sagitta.
double sample_arc(const GivenCurve& arc, Point2 p, Point2 q, std::vector<Point2>& out) {
  const double radius = distance(arc.centre, p), whole = distance(p, q);
  const int parts = parts_for(whole * whole / (8.0 * radius));
  double longest = 0.0;
  Point2 before = p;
  const auto reach = [&](Point2 at) {
    longest = std::max(longest, distance(before, at));
    before = at;
  };
  for (int k = 1; k < parts; ++k) {
    const double x = double(k) / parts;
    const Point2 off{p.x_mm + x * (q.x_mm - p.x_mm) - arc.centre.x_mm,
                     p.y_mm + x * (q.y_mm - p.y_mm) - arc.centre.y_mm};
    const double scale = radius / std::sqrt(squared_length(off));
    out.push_back({arc.centre.x_mm + scale * off.x_mm, arc.centre.y_mm + scale * off.y_mm});
    reach(out.back());
  }
  reach(q);
  const double share = std::min(1.0, 0.5 * longest / radius);
  return radius * share * share / (1.0 + std::sqrt(1.0 - share * share));
}

/// The same of a Bezier curve between two parameters: a chord is off by at most |r''| (to - from)^2 / 8.
double sample_bezier(const GivenCurve& b, double from, double to, std::vector<Point2>& out) {
  const auto bend = [](Point2 p, Point2 q, Point2 r) {
    return 6.0 * std::sqrt(squared_length({p.x_mm - 2.0 * q.x_mm + r.x_mm, p.y_mm - 2.0 * q.y_mm + r.y_mm}));
  };
  const double most =
      std::max(bend(b.start, b.control[0], b.control[1]), bend(b.control[0], b.control[1], b.end));
  const double whole = most * (to - from) * (to - from) / 8.0;
  const int parts = parts_for(whole);
  for (int k = 1; k < parts; ++k) out.push_back(b.at(from + (to - from) * double(k) / parts));
  return whole / (double(parts) * parts);
}

/// Unit tangent of a Bezier curve; where a control point lies on its end, towards the next one.
Point2 tangent(const GivenCurve& b, double parameter) {
  const double low = std::max(0.0, parameter - kTangentStep), high = std::min(1.0, parameter + kTangentStep);
  const auto edge = [](Point2 p, Point2 q, double x) {
    return Point2{x * (q.x_mm - p.x_mm), x * (q.y_mm - p.y_mm)};
  };
  const double x = parameter, y = 1.0 - x;
  const Point2 e[3] = {edge(b.start, b.control[0], y * y), edge(b.control[0], b.control[1], 2.0 * x * y),
                       edge(b.control[1], b.end, x * x)};
  Point2 d{e[0].x_mm + e[1].x_mm + e[2].x_mm, e[0].y_mm + e[1].y_mm + e[2].y_mm};
  if (d.x_mm == 0.0 && d.y_mm == 0.0) d = edge(b.at(low), b.at(high), 1.0);
  const double length = std::sqrt(squared_length(d));
  return length > 0.0 ? Point2{d.x_mm / length, d.y_mm / length} : Point2{1.0, 0.0};
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

PathDirection direction_at(std::span<const Point2> p, std::span<const GivenCurve> given, std::size_t i,
                           bool after) {
  const auto end = [after](const GivenCurve& g) { return after ? g.first : g.last; };
  const auto curve =
      std::partition_point(given.begin(), given.end(), [&](const GivenCurve& g) { return end(g) < i; });
  if (curve == given.end() || end(*curve) != i) {
    const Point2 &a = p[after ? i : i - 1], &b = p[after ? i + 1 : i];
    const double length = distance(a, b);
    return {{(b.x_mm - a.x_mm) / length, (b.y_mm - a.y_mm) / length}, 0.0};
  }
  if (curve->kind == GivenCurve::Kind::kBezier) {
    const double u = after ? curve->from : curve->to;
    const Point2 t = tangent(*curve, u), bend = curve->bend(u);
    return {t, t.x_mm * bend.y_mm - t.y_mm * bend.x_mm};
  }
  const Point2 r{p[i].x_mm - curve->centre.x_mm, p[i].y_mm - curve->centre.y_mm};
  const double side = curve->clockwise ? -1.0 : 1.0, radius = std::sqrt(squared_length(r));
  return {{-side * r.y_mm / radius, side * r.x_mm / radius}, side / radius};
}

GivenReference sample_given(std::span<const Point2> points, std::span<const GivenCurve> given,
                            std::vector<Point2>& out) {
  if (given.empty()) return {points};
  out.clear();
  double most = 0.0;
  std::size_t k = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    out.push_back(points[i]);
    while (k < given.size() && given[k].last <= i) ++k;
    if (k == given.size() || given[k].first > i) continue;
    const GivenCurve& curve = given[k];
    const double step = (curve.to - curve.from) / double(curve.last - curve.first);
    const double sagitta = curve.kind == GivenCurve::Kind::kArc
                               ? sample_arc(curve, points[i], points[i + 1], out)
                               : sample_bezier(curve, curve.from + step * double(i - curve.first),
                                               curve.from + step * double(i + 1 - curve.first), out);
    most = std::max(most, sagitta);
  }
  return {out, most};
}

}  // namespace firn::motion
