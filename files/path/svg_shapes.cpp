#include "files/path/svg_shapes.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

#include "files/path/bezier_pieces.h"
#include "files/path/svg_scanner.h"

namespace firn::svg {
namespace {

Point2 operator+(Point2 a, Point2 b) { return {a.x_mm + b.x_mm, a.y_mm + b.y_mm}; }
Point2 operator-(Point2 a, Point2 b) { return {a.x_mm - b.x_mm, a.y_mm - b.y_mm}; }
Point2 operator*(double k, Point2 a) { return {k * a.x_mm, k * a.y_mm}; }

}  // namespace

Pen::Pen(const PlaneTransform& t, const Target& target) : to_mm_(t), target_(target) {
  constexpr double kAlike = 1e-12;
  const double x = t.a * t.a + t.b * t.b, y = t.c * t.c + t.d * t.d;
  scale_ = std::sqrt(x + y);
  if (std::abs(x - y) <= kAlike * x && std::abs(t.a * t.c + t.b * t.d) <= kAlike * x)
    turns_ = t.a * t.d > t.b * t.c ? 1.0 : -1.0;
}

void Pen::move(Point2 p) {
  at_ = start_ = p;
  open_ = false;
}

void Pen::begin() {
  if (!open_) target_.begin(to_mm_(at_));
  open_ = true;
}

void Pen::line(Point2 p) {
  begin();
  target_.line(to_mm_(p));
  at_ = p;
}

void Pen::cubic(Point2 b, Point2 c, Point2 d) {
  begin();
  target_.cubic(to_mm_(b), to_mm_(c), to_mm_(d));
  at_ = d;
}

void Pen::close() {
  if (open_) target_.line(to_mm_(start_));
  at_ = start_;
  open_ = false;
}

void Pen::arc(double rx, double ry, double turn_deg, bool large, bool sweep, Point2 to) {
  rx = std::abs(rx);
  ry = std::abs(ry);
  if (to == at_) return;
  if (!(rx > 0.0) || !(ry > 0.0)) return line(to);
  const PlaneTransform turn = PlaneTransform::rotation_deg(turn_deg),
                       back = PlaneTransform::rotation_deg(-turn_deg);
  const Point2 half = back(0.5 * (at_ - to)), from = at_;
  const double x = half.x_mm / rx, y = half.y_mm / ry, square = x * x + y * y;
  if (square > 1.0) {  // too small to reach: scaled up
    rx *= std::sqrt(square);
    ry *= std::sqrt(square);
  }
  const double u = half.x_mm / rx, v = half.y_mm / ry, inside = u * u + v * v;
  const double away = std::sqrt(std::max(0.0, 1.0 / inside - 1.0)) * (large == sweep ? -1.0 : 1.0);
  const Point2 centre{away * v, -away * u};  // in units of the radii
  const double start = std::atan2(v - centre.y_mm, u - centre.x_mm);
  double angle = std::atan2(-v - centre.y_mm, -u - centre.x_mm) - start;
  if (sweep && angle < 0.0) angle += 2.0 * std::numbers::pi;
  if (!sweep && angle > 0.0) angle -= 2.0 * std::numbers::pi;
  if (!std::isfinite(angle)) return line(to);  // radii beyond any limit: the ends are judged
  const Point2 middle = 0.5 * (from + to);
  const auto place = [&](Point2 p) {
    return middle + turn({rx * (centre.x_mm + p.x_mm), ry * (centre.y_mm + p.y_mm)});
  };
  constexpr double kAlike = 1e-12;
  if (turns_ != 0.0 && std::abs(rx - ry) <= kAlike * rx) {
    begin();
    target_.arc(to_mm_(place({})), sweep ? turns_ : -turns_, to_mm_(to));
    at_ = to;
    return;
  }
  const int parts = ellipse_pieces(scale_ * std::max(rx, ry));
  const int n = std::max(1, int(std::ceil(std::abs(angle) * parts / (2.0 * std::numbers::pi))));
  const double step = angle / n, handle = 4.0 / 3.0 * std::tan(0.25 * step);
  for (int i = 0; i < n; ++i) {
    const double a = start + i * step, b = a + step;
    const Point2 p{std::cos(a), std::sin(a)}, q{std::cos(b), std::sin(b)};
    cubic(place(p + handle * Point2{-p.y_mm, p.x_mm}), place(q - handle * Point2{-q.y_mm, q.x_mm}),
          i + 1 < n ? place(q) : to);
  }
}

void draw_path(std::string_view data, Pen& pen) {
  Scanner text(data);
  char command = '\0', before = '\0';
  Point2 control;  // of the curve before, for S and T
  bool moved = false;
  while (!text.empty()) {
    if (!text.at_number())
      command = text.letter();
    else if (command == 'M' || command == 'm')
      command = command == 'M' ? 'L' : 'l';
    else if (command == '\0' || command == 'Z' || command == 'z')
      text.fail("path data: a command is needed");
    const char kind = char(std::toupper(static_cast<unsigned char>(command)));
    const bool relative = kind != command;
    if (kind != 'M' && !moved) text.fail("path data must begin with M");
    const Point2 at = pen.at(), origin = relative ? at : Point2{};
    const auto point = [&] { return origin + text.point(); };
    const auto mirrored = [&](std::string_view after) {
      return after.find(before) != after.npos ? at + (at - control) : at;
    };
    const auto quadratic = [&](Point2 q, Point2 to) {
      control = q;
      pen.cubic(at + (2.0 / 3.0) * (q - at), to + (2.0 / 3.0) * (q - to), to);
    };
    switch (kind) {
      case 'M':
        pen.move(point());
        moved = true;
        break;
      case 'L':
        pen.line(point());
        break;
      case 'H':
        pen.line({origin.x_mm + text.next(), at.y_mm});
        break;
      case 'V':
        pen.line({at.x_mm, origin.y_mm + text.next()});
        break;
      case 'C':
      case 'S': {
        const Point2 b = kind == 'C' ? point() : mirrored("CS");
        control = point();
        pen.cubic(b, control, point());
        break;
      }
      case 'Q': {
        const Point2 q = point();
        quadratic(q, point());
        break;
      }
      case 'T': {
        const Point2 q = mirrored("QT");
        quadratic(q, point());
        break;
      }
      case 'A': {
        const double rx = text.next(), ry = text.next(), turn = text.next();
        const bool large = text.flag(), sweep = text.flag();
        pen.arc(rx, ry, turn, large, sweep, point());
        break;
      }
      case 'Z':
        pen.close();
        break;
      default:
        text.fail("path data: M, L, H, V, C, S, Q, T, A or Z is needed");
    }
    before = kind;
  }
}

void draw_polygon(std::string_view points, bool closed, Pen& pen) {
  Scanner text(points);
  for (bool first = true; !text.empty(); first = false) {
    const Point2 p = text.point();
    first ? pen.move(p) : pen.line(p);
  }
  if (closed) pen.close();
}

void draw_rect(Point2 corner, double w, double h, double rx, double ry, Pen& pen) {
  constexpr double kSame = 1e-12;
  if (!(w > 0.0) || !(h > 0.0)) return;
  rx = std::clamp(rx, 0.0, 0.5 * w);
  ry = std::clamp(ry, 0.0, 0.5 * h);
  if (rx == 0.0 || ry == 0.0) rx = ry = 0.0;
  const double left = corner.x_mm, top = corner.y_mm, right = left + w, bottom = top + h;
  const auto side = [&](Point2 to) {
    if (distance(pen.at(), to) > kSame * (w + h)) pen.line(to);
  };
  const auto round = [&](Point2 to) {
    if (rx > 0.0) pen.arc(rx, ry, 0.0, false, true, to);
  };
  pen.move({left + rx, top});
  side({right - rx, top});
  round({right, top + ry});
  side({right, bottom - ry});
  round({right - rx, bottom});
  side({left + rx, bottom});
  round({left, bottom - ry});
  side({left, top + ry});
  round({left + rx, top});
  pen.close();
}

void draw_ellipse(Point2 centre, double rx, double ry, Pen& pen) {
  if (!(rx > 0.0) || !(ry > 0.0)) return;
  pen.move({centre.x_mm + rx, centre.y_mm});
  pen.arc(rx, ry, 0.0, false, true, {centre.x_mm - rx, centre.y_mm});
  pen.arc(rx, ry, 0.0, false, true, {centre.x_mm + rx, centre.y_mm});
}

}  // namespace firn::svg
