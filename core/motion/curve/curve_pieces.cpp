#include "core/motion/curve/curve_pieces.h"

#include <algorithm>
#include <cmath>

#include "core/exact/exact_math.h"
#include "core/motion/curve/given_curves.h"

namespace firn::motion {
namespace {

struct Vec {
  double x, y;
};
Vec operator-(Point2 a, Point2 b) { return {a.x_mm - b.x_mm, a.y_mm - b.y_mm}; }
double norm(Vec v) { return std::sqrt(v.x * v.x + v.y * v.y); }
double cross(Vec a, Vec b) { return a.x * b.y - a.y * b.x; }
double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y; }

/// Last point of the longest run from i that lies on one line: the sleeve of directions that pass every
/// point.
std::size_t line_run(std::span<const Point2> p, std::size_t i) {
  const Vec base = p[i + 1] - p[i];
  const double length = norm(base);
  const Vec t{base.x / length, base.y / length};
  double low = -kRecogniseMm / length, high = kRecogniseMm / length, before = length;
  std::size_t last = i + 1;
  for (std::size_t k = i + 2; k < p.size(); ++k) {
    const Vec v = p[k] - p[i];
    const double along = dot(t, v), aside = cross(t, v);
    if (along <= before) break;
    const double slope = aside / along, width = kRecogniseMm / along;
    if (slope < low || slope > high) break;
    low = std::max(low, slope - width);
    high = std::min(high, slope + width);
    before = along;
    last = k;
  }
  return last;
}

struct Circle {
  Point2 centre;
  double curvature = 0.0;  ///< 0: no circle
};

Circle circle_through(Point2 a, Point2 b, Point2 c) {
  const Vec u = b - a, v = c - a;
  const double twice_area = cross(u, v), uu = dot(u, u), vv = dot(v, v);
  Circle circle;
  if (twice_area * twice_area < 1e-24 * uu * vv) return circle;
  const double x = (v.y * uu - u.y * vv) / (2.0 * twice_area), y = (u.x * vv - v.x * uu) / (2.0 * twice_area);
  const double radius = std::sqrt(x * x + y * y);
  if (radius > 1e5) return circle;
  circle.centre = {a.x_mm + x, a.y_mm + y};
  circle.curvature = (twice_area > 0.0 ? 1.0 : -1.0) / radius;
  return circle;
}

/// Whether the points i..j lie on the circle through i, the middle and j, going round one way in short
/// chords.
bool on_circle(std::span<const Point2> p, std::size_t i, std::size_t j, double sagitta_mm, Circle& circle) {
  circle = circle_through(p[i], p[(i + j) / 2], p[j]);
  if (circle.curvature == 0.0) return false;
  const double radius = 1.0 / std::abs(circle.curvature), turn = circle.curvature > 0.0 ? 1.0 : -1.0;
  const double low = (radius - kRecogniseMm) * std::abs(radius - kRecogniseMm),
               high = (radius + kRecogniseMm) * (radius + kRecogniseMm);
  const double longest = 8.0 * sagitta_mm * radius;  // chord^2 = 8 R sagitta
  Vec before = p[i] - circle.centre;
  double turned = 0.0;
  for (std::size_t k = i; k <= j; ++k) {
    const Vec r = p[k] - circle.centre;
    const double rr = dot(r, r);
    if (rr < low || rr > high) return false;
    if (k == i) continue;
    const Vec chord = p[k] - p[k - 1];
    if (dot(chord, chord) > longest || turn * cross(before, r) <= 0.0 || dot(before, r) <= 0.0) return false;
    turned += std::abs(cross(before, r)) / (radius * radius);
    before = r;
  }
  return turned < 6.2;  // less than one round, so that start and end stay apart
}

/// Last point of the longest run from i on one circle (at least 4 points), or i.
std::size_t arc_run(std::span<const Point2> p, std::size_t i, double sagitta_mm, Circle& circle) {
  if (i + 3 >= p.size()) return i;
  Circle trial;
  std::size_t good = i, step = 3;
  while (i + step < p.size() && on_circle(p, i, i + step, sagitta_mm, trial)) {
    good = i + step;
    circle = trial;
    step *= 2;
  }
  if (good == i) return i;
  std::size_t bad = std::min(i + step, p.size());
  while (bad - good > 1) {
    const std::size_t middle = good + (bad - good) / 2;
    if (on_circle(p, i, middle, sagitta_mm, trial)) {
      good = middle;
      circle = trial;
    } else
      bad = middle;
  }
  return good;
}

/// True if a run i..j on one line or circle ends abruptly, as lines and arcs do that are meant: two points
/// beyond, a smooth curve has left its osculating circle by little (by 16 times kRecogniseMm for five points,
/// by less for more). @param off distance of a point from the line or circle
template <class Off>
bool ends_abruptly(std::span<const Point2> p, std::size_t i, std::size_t j, Off&& off) {
  const auto abrupt = [&](std::size_t k) {
    const double d = off(p[k]);
    return d <= kSameRun_mm || d > kAbruptEnd_mm;
  };
  return (i < 2 || abrupt(i - 2)) && (j + 2 >= p.size() || abrupt(j + 2));
}

/// Sets start, tangent and length of an arc between two points near its circle.
void set_arc(CurvePiece& piece, const Circle& circle, Point2 from, Point2 to) {
  const Vec a = from - circle.centre, b = to - circle.centre;
  const double turn = circle.curvature > 0.0 ? 1.0 : -1.0, ra = norm(a);
  piece.start = from;
  piece.tx = -turn * a.y / ra;
  piece.ty = turn * a.x / ra;
  piece.curvature = circle.curvature;
  double angle = turn * exact::atan2(cross(a, b), dot(a, b));
  if (angle < 0.0) angle += 6.283185307179586;
  piece.length_mm = angle / std::abs(circle.curvature);
}

void set_line(CurvePiece& piece, Point2 from, Point2 to) {
  const Vec v = to - from;
  piece.length_mm = norm(v);
  piece.start = from;
  if (piece.length_mm > 0.0) {
    piece.tx = v.x / piece.length_mm;
    piece.ty = v.y / piece.length_mm;
  }
  piece.curvature = 0.0;
}

Circle circle_of(const CurvePiece& arc) {
  const double r = 1.0 / arc.curvature;
  return {{arc.start.x_mm - r * arc.ty, arc.start.y_mm + r * arc.tx}, arc.curvature};
}

Point2 end_of(const CurvePiece& piece) { return piece.at(piece.length_mm); }

/// The point where two recognised pieces are tangent, if they are.
bool tangency(const CurvePiece& a, const CurvePiece& b, Point2& joint) {
  if (a.curvature == 0.0 && b.curvature == 0.0) return false;
  if (a.curvature != 0.0 && b.curvature != 0.0) {
    const Circle ca = circle_of(a), cb = circle_of(b);
    const double ra = 1.0 / a.curvature, rb = 1.0 / b.curvature;  // signed: centres on the left are positive
    const Vec d = cb.centre - ca.centre;
    const double distance = norm(d), difference = ra - rb;
    if (std::abs(distance - std::abs(difference)) > kTangency_mm || distance < 1e-6) return false;
    // on a's circle, and within the kTangency_mm on b's; divided by the difference it lies off both where
    // they are nearly one circle
    const double along = ra / std::copysign(distance, difference);
    joint = {ca.centre.x_mm + d.x * along, ca.centre.y_mm + d.y * along};
    return true;
  }
  const CurvePiece& line = a.curvature == 0.0 ? a : b;
  const Circle circle = circle_of(a.curvature == 0.0 ? b : a);
  const Vec t{line.tx, line.ty}, v = circle.centre - line.start;
  if (std::abs(cross(t, v) - 1.0 / circle.curvature) > kTangency_mm) return false;
  const double along = dot(t, v);
  joint = {line.start.x_mm + along * t.x, line.start.y_mm + along * t.y};
  return true;
}

/// Moves the border between two pieces to `joint`. False if it lies further from their present ends than
/// `reach`.
bool join(CurvePiece& a, CurvePiece& b, Point2 joint, double reach) {
  if (norm(joint - end_of(a)) > reach || norm(joint - b.start) > reach) return false;
  CurvePiece left = a, right = b;
  const Point2 end = end_of(b);
  if (a.curvature == 0.0)
    left.length_mm = dot({a.tx, a.ty}, joint - a.start);
  else
    set_arc(left, circle_of(a), a.start, joint);
  if (b.curvature == 0.0)
    set_line(right, joint, end);
  else
    set_arc(right, circle_of(b), joint, end);
  if (left.length_mm < 0.25 * a.length_mm || right.length_mm < 0.25 * b.length_mm ||
      left.length_mm > 2.0 * a.length_mm || right.length_mm > 2.0 * b.length_mm)
    return false;
  a = left;
  b = right;
  return true;
}

/// Joins tangent neighbours; drops a chord between two recognised pieces when these are tangent across it.
void join_tangent(std::span<const Point2> points, std::vector<CurvePiece>& pieces) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    CurvePiece piece = pieces[k];
    Point2 joint;
    const auto chord_at = [&](const CurvePiece& p) { return norm(points[p.first + 1] - points[p.first]); };
    if (!piece.chord && kept > 0) {
      if (!pieces[kept - 1].chord) {
        if (tangency(pieces[kept - 1], piece, joint))
          join(pieces[kept - 1], piece, joint, 1.01 * chord_at(piece));
      } else if (kept > 1 && !pieces[kept - 2].chord && tangency(pieces[kept - 2], piece, joint)) {
        CurvePiece left = pieces[kept - 2];
        if (join(left, piece, joint, 1.01 * pieces[kept - 1].length_mm)) pieces[--kept - 1] = left;
      }
    }
    pieces[kept++] = piece;
  }
  pieces.resize(kept);
}

}  // namespace

Point2 CurvePiece::at(double s) const {
  if (curvature == 0.0) return {start.x_mm + s * tx, start.y_mm + s * ty};
  const double angle = s * curvature, r = 1.0 / curvature;
  const double along = exact::sin(angle) * r, half = exact::sin(0.5 * angle), aside = 2.0 * half * half * r;
  return {start.x_mm + along * tx - aside * ty, start.y_mm + along * ty + aside * tx};
}

Point2 CurvePiece::tangent(double s) const {
  if (curvature == 0.0) return {tx, ty};
  const auto [n, c] = exact::sincos(s * curvature);
  return {c * tx - n * ty, c * ty + n * tx};
}

void recognise(std::span<const Point2> p, double sagitta_mm, std::vector<CurvePiece>& pieces) {
  pieces.clear();
  for (std::size_t i = 0; i + 1 < p.size();) {
    CurvePiece piece;
    piece.first = i;
    Circle circle;
    const std::size_t line = line_run(p, i);
    const std::size_t arc = line + 1 < p.size() ? arc_run(p, i, sagitta_mm, circle) : i;
    if (arc > line && arc >= i + 3) set_arc(piece, circle, p[i], p[arc]);
    const auto off_circle = [&](Point2 q) {
      return std::abs(norm(q - circle.centre) - 1.0 / std::abs(circle.curvature));
    };
    // four points of a smooth curve may lie on one circle, three on one line, by chance
    std::size_t chords = i + 1;  // up to where the points are no run; half of a chance run, to stay linear
    if (arc > line &&
        (arc >= i + 4 || (arc == i + 3 && piece.length_mm * std::abs(piece.curvature) > kMinArcTurn_rad)) &&
        (piece.length_mm > kLongRun_mm || ends_abruptly(p, i, arc, off_circle))) {
      piece.last = arc;
    } else {
      if (arc > line && arc >= i + 4) chords = std::max(chords, i + (arc - i) / 2);
      set_line(piece, p[i], p[line]);
      const auto off_line = [&](Point2 q) { return std::abs(cross({piece.tx, piece.ty}, q - piece.start)); };
      const bool certain =
          (line >= i + 3 || (line == i + 2 && (piece.length_mm > kMinLine_mm || p.size() == 3))) &&
          (piece.length_mm > kLongRun_mm || ends_abruptly(p, i, line, off_line));
      if (!certain && line > i + 1) set_line(piece, p[i], p[i + 1]);
      if (!certain && line >= i + 3) chords = std::max(chords, i + (line - i) / 2);
      piece.last = certain ? line : i + 1;
      piece.chord = !certain;
    }
    i = piece.last;
    pieces.push_back(piece);
    for (; piece.chord && i < chords; ++i) {
      piece.first = i;
      piece.last = i + 1;
      set_line(piece, p[i], p[i + 1]);
      pieces.push_back(piece);
    }
  }
  join_tangent(p, pieces);
}

namespace {

/// Appends the pieces of the points between two given curves. @param part their own pieces, a buffer
void append_recognised(std::span<const Point2> p, std::size_t from, std::size_t to, double sagitta_mm,
                       std::vector<CurvePiece>& part, std::vector<CurvePiece>& pieces) {
  if (from == to) return;
  recognise(p.subspan(from, to - from + 1), sagitta_mm, part);
  for (CurvePiece& piece : part) {
    piece.first += from;
    piece.last += from;
    pieces.push_back(piece);
  }
}

/// Chords of a sample interval of a Bezier curve, the first one no longer than `first_mm` and each further
/// one twice as long; in the other order where they lead to its end.
void append_parted(const GivenCurve& curve, std::size_t i, double first_mm, bool at_end,
                   std::vector<CurvePiece>& pieces) {
  const double step = (curve.to - curve.from) / double(curve.last - curve.first),
               from = curve.from + step * double(i - curve.first);
  const double length = distance(curve.at(from), curve.at(from + step));
  int halvings = 0;
  while (halvings < kMaxHalvings && std::ldexp(length, -halvings) > first_mm) ++halvings;
  double before = 0.0;
  for (int k = 0; k <= halvings; ++k) {
    const double to =
        at_end ? (k < halvings ? 1.0 - std::ldexp(1.0, -k - 1) : 1.0) : std::ldexp(1.0, k - halvings);
    CurvePiece piece;
    piece.given = piece.chord = true;
    piece.first = i;
    piece.last = i + 1;
    set_line(piece, curve.at(from + before * step), curve.at(from + to * step));
    pieces.push_back(piece);
    before = to;
  }
}

/// @param first_mm, last_mm longest chord of a Bezier curve at its two ends
void append_bezier(std::span<const Point2> p, const GivenCurve& curve, double first_mm, double last_mm,
                   std::vector<CurvePiece>& pieces) {
  for (std::size_t i = curve.first; i < curve.last; ++i) {
    const double chord = norm(p[i + 1] - p[i]);
    if (i == curve.first && first_mm < chord) {
      append_parted(curve, i, first_mm, false, pieces);
    } else if (i + 1 == curve.last && last_mm < chord) {
      append_parted(curve, i, last_mm, true, pieces);
    } else {
      CurvePiece piece;
      piece.given = piece.chord = true;
      piece.first = i;
      piece.last = i + 1;
      set_line(piece, p[i], p[i + 1]);
      pieces.push_back(piece);
    }
  }
}

void append_arc(std::span<const Point2> p, const GivenCurve& curve, std::vector<CurvePiece>& pieces) {
  const double curvature = 1.0 / distance(curve.centre, p[curve.first]);  // one of both parts: no ramp there
  const auto append = [&](std::size_t from, std::size_t to) {
    CurvePiece piece;
    piece.given = true;
    piece.first = from;
    piece.last = to;
    set_arc(piece, {curve.centre, curve.clockwise ? -curvature : curvature}, p[from], p[to]);
    pieces.push_back(piece);
  };
  // a full circle ends at its first point, give or take rounding: its middle tells it from no turn at all
  const auto turn = [&](std::size_t from, std::size_t to) {
    const Vec a = p[from] - curve.centre, b = p[to] - curve.centre;
    const double angle = (curve.clockwise ? -1.0 : 1.0) * exact::atan2(cross(a, b), dot(a, b));
    return angle < 0.0 ? angle + 6.283185307179586 : angle;
  };
  std::size_t middle = (curve.first + curve.last) / 2;
  if (middle == curve.first || turn(curve.first, middle) + turn(middle, curve.last) < kMaxArcPiece_rad)
    middle = curve.last;
  append(curve.first, middle);
  if (middle < curve.last) append(middle, curve.last);
}

}  // namespace

double exact_spacing_mm(double jump, double turn, double ramp_mm, double within_mm) {
  // off by u h^2 / 41 at a step u of the second derivative between equal cells, by more where they grow
  const double a = std::abs(jump) / kJumpDivisor, b = std::abs(turn) / kTurnDivisor;  // a h^2 + b h = within
  const double root = b + std::sqrt(b * b + 4.0 * a * within_mm);
  return root > 0.0 ? std::min(0.5 * ramp_mm, 2.0 * within_mm / root) : 0.5 * ramp_mm;
}

void recognise(std::span<const Point2> p, std::span<const GivenCurve> given, double sagitta_mm,
               double ramp_mm, std::vector<CurvePiece>& pieces) {
  if (given.empty()) return recognise(p, sagitta_mm, pieces);
  pieces.clear();
  std::vector<CurvePiece> part;
  std::size_t at = 0;
  const auto append_points = [&](std::size_t to) {
    if (at == to) return;
    append_recognised(p, at, to, sagitta_mm, part, pieces);
    if (to == at + 1) pieces.back().chord = false;
  };
  const auto spacing_mm = [&](std::size_t k, bool at_end) {
    const std::size_t i = at_end ? given[k].last : given[k].first;
    if (!(ramp_mm > 0.0) || i == 0 || i + 1 == p.size()) return 1e300;
    const PathDirection before = direction_at(p, given, i, false), after = direction_at(p, given, i, true);
    return exact_spacing_mm(after.curvature - before.curvature, distance(before.tangent, after.tangent),
                            ramp_mm);
  };
  for (std::size_t k = 0; k < given.size(); ++k) {
    const GivenCurve& curve = given[k];
    append_points(curve.first);
    if (curve.kind == GivenCurve::Kind::kBezier)
      append_bezier(p, curve, spacing_mm(k, false), spacing_mm(k, true), pieces);
    else
      append_arc(p, curve, pieces);
    at = curve.last;
  }
  append_points(p.size() - 1);
}

bool has_dense_run(std::span<const CurvePiece> pieces, double longest_mm) {
  std::size_t chords = 0;
  for (const CurvePiece& piece : pieces) {
    chords = piece.chord && piece.length_mm < longest_mm ? chords + 1 : 0;
    if (chords >= kMinDenseChords) return true;
  }
  return false;
}

void split_points(std::span<const Point2> p, double cos_split, std::vector<std::size_t>& splits) {
  splits.assign(1, 0);
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const Vec a = p[i] - p[i - 1], b = p[i + 1] - p[i];
    if (dot(a, b) < cos_split * std::sqrt(dot(a, a) * dot(b, b))) splits.push_back(i);
  }
  splits.push_back(p.size() - 1);
}

}  // namespace firn::motion
