// Arcs and Bezier curves of path files are carried as such: every sample of one lies on it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "files/path/path_file.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_gcode> read_nc{"part.nc"};
constexpr test::PathReader<read_paths_json> read_json{"part.json"};
constexpr test::PathReader<read_paths_dxf> read_dxf{"part.dxf"};
constexpr test::PathReader<read_paths_svg> read_svg{"part.svg"};

/// On a page whose unit is a millimetre, with the origin at its upper edge.
InputPath of_svg(const std::string& content) {
  return read_svg("<svg width='100mm' height='100mm' viewBox='0 0 100 100'>" + content + "</svg>").at(0);
}

bool all_of(const InputPath& path, GivenCurve::Kind kind) {
  for (const GivenCurve& g : path.given)
    if (g.kind != kind) return false;
  return !path.given.empty();
}

/// Number of points that belong to no given curve but for its ends.
std::size_t beside_given(const InputPath& path) {
  std::size_t inside = 0;
  for (const GivenCurve& g : path.given) inside += g.last - g.first;
  return path.path.points.size() - 1 - inside;
}

/// Largest distance of a sample from the given curve that it belongs to.
double off_given(const InputPath& path) {
  double most = 0.0;
  for (const GivenCurve& g : path.given) {
    REQUIRE(g.first < g.last);
    REQUIRE(g.last < path.path.points.size());
    const double radius = distance(g.centre, path.path.points[g.first]);
    for (std::size_t i = g.first; i <= g.last; ++i) {
      const Point2 p = path.path.points[i];
      most = std::max(most, g.kind == GivenCurve::Kind::kArc
                                ? std::abs(distance(g.centre, p) - radius)
                                : distance(g.at(double(i - g.first) / double(g.last - g.first)), p));
    }
  }
  return most;
}

/// A spline by the sum of Cox and de Boor's basis functions, at a parameter below the last knot.
struct BasisSpline {
  int degree;
  std::vector<double> knots, weights;
  std::vector<Point2> control;

  double basis(std::size_t i, int d, double u) const {
    if (d == 0) return u >= knots[i] && u < knots[i + 1] ? 1.0 : 0.0;
    const std::size_t n = std::size_t(d);
    const double a = knots[i + n] - knots[i], b = knots[i + n + 1] - knots[i + 1];
    return (a > 0.0 ? (u - knots[i]) / a * basis(i, d - 1, u) : 0.0) +
           (b > 0.0 ? (knots[i + n + 1] - u) / b * basis(i + 1, d - 1, u) : 0.0);
  }
  Point2 at(double u) const {
    double x = 0.0, y = 0.0, w = 0.0;
    for (std::size_t i = 0; i < control.size(); ++i) {
      const double share = weights[i] * basis(i, degree, u);
      x += share * control[i].x_mm;
      y += share * control[i].y_mm;
      w += share;
    }
    return {x / w, y / w};
  }
  /// Distance of a point, by Gauss-Newton from the nearest of many samples.
  double off(Point2 p) const {
    constexpr int kSamples = 300;
    const double end = knots.back() * (1.0 - 1e-12), step = 1e-6 * end;
    double best = 0.0;
    for (int i = 0; i <= kSamples; ++i)
      if (distance(at(end * i / kSamples), p) < distance(at(best), p)) best = end * i / kSamples;
    for (int k = 0; k < 20; ++k) {
      const double low = std::max(0.0, best - step), high = std::min(end, best + step);
      const Point2 a = at(low), b = at(high), c = at(best);
      const double dx = (b.x_mm - a.x_mm) / (high - low), dy = (b.y_mm - a.y_mm) / (high - low);
      best -= ((c.x_mm - p.x_mm) * dx + (c.y_mm - p.y_mm) * dy) / (dx * dx + dy * dy);
      best = std::clamp(best, 0.0, end);
    }
    return distance(at(best), p);
  }
  std::string entity() const {
    std::ostringstream out;
    out.precision(17);
    out << "0 SPLINE 8 0 71 " << degree;
    for (const double u : knots) out << " 40 " << u;
    for (const double w : weights) out << " 41 " << w;
    for (const Point2& p : control) out << " 10 " << p.x_mm << " 20 " << p.y_mm;
    return out.str();
  }
};

/// Clamped, with inner knots at whole numbers.
BasisSpline random_spline(RandomStream& draw, int degree, bool rational) {
  BasisSpline s;
  s.degree = degree;
  const int count = degree + 2 + int(draw.below(6)), last = count - degree;
  for (int i = 0; i <= count + degree; ++i) s.knots.push_back(std::clamp(i - degree, 0, last));
  for (int i = 0; i < count; ++i) {
    s.control.push_back({8.0 * i + draw.uniform(-3.0, 3.0), draw.uniform(-12.0, 12.0)});
    s.weights.push_back(rational ? draw.uniform(0.3, 3.0) : 1.0);
  }
  return s;
}

std::string dxf_lines(std::string words) {
  for (char& c : words)
    if (c == ' ') c = '\n';
  return words + "\n";
}

}  // namespace

TEST_CASE("G2 and G3 in three decimals are circles through both ends, however their centres are rounded") {
  RandomStream draw(3, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    const double radius = draw.uniform(0.5, 40.0), from = draw.uniform(0.0, 6.28),
                 turn = draw.uniform(0.05, 3.1);
    const bool clockwise = draw.below(2) == 1;
    const auto at = [&](double a) { return Point2{7.0 + radius * std::cos(a), radius * std::sin(a)}; };
    const auto three = [](double v) { return std::round(v * 1000.0) / 1000.0; };
    const Point2 a = at(from), b = at(clockwise ? from - turn : from + turn);
    char text[200];
    std::snprintf(text, sizeof text, "G0 X%.3f Y%.3f\n%s X%.3f Y%.3f I%.3f J%.3f F600\nG1 X80\n", a.x_mm,
                  a.y_mm, clockwise ? "G2" : "G3", b.x_mm, b.y_mm, 7.0 - three(a.x_mm), -three(a.y_mm));
    const InputPath path = read_nc(text).at(0);
    INFO(text);
    REQUIRE(path.given.size() == 1);
    CHECK(path.given[0].clockwise == clockwise);
    CHECK(path.given[0].first == 0);
    CHECK(path.path.points[path.given[0].last] == Point2{three(b.x_mm), three(b.y_mm)});
    CHECK(off_given(path) < 1e-9);
    // far from a change of the feed the arc is where its rounded words put it
    for (std::size_t i = 0; i <= path.given[0].last; ++i)
      CHECK(std::abs(distance(path.path.points[i], {7.0, 0.0}) - radius) < 2.5e-3);
  }
}

TEST_CASE("An arc that is nearly a circle, and whose ends' radii differ, is not another arc") {
  const InputPath path = read_nc("G0 X10 Y0\nG3 X10.002 Y-0.01 I-10 J0\n").at(0);
  CHECK(path.given.empty());
  for (const Point2& p : path.path.points) CHECK(std::abs(distance(p, {}) - 10.0) < 0.003);
  // nor is one that is as short as the rounding of its ends
  const InputPath tiny = read_nc("G0 X10 Y0\nG3 X10.0005 Y0.0001 I-10 J0\nG1 X20\n").at(0);
  CHECK(tiny.given.empty());
  for (const Point2& p : tiny.path.points) CHECK(p.x_mm > 9.99);
}

TEST_CASE("Given curves keep their points where a change of feed adds others before them") {
  const InputPath path =
      read_nc("G0 X0\nG1 X10 F6000\nX20 F600\nX30 F6000\nG3 X30 Y10 J5\nG5 I1 J1 P1 Q-1 X20 Y10\n").at(0);
  REQUIRE(path.given.size() == 2);
  CHECK(path.path.points[path.given[0].first] == Point2{30, 0});
  CHECK(path.path.points[path.given[0].last] == Point2{30, 10});
  CHECK(path.given[1].first == path.given[0].last);
  CHECK(path.given[1].last + 1 == path.path.points.size());
  CHECK(off_given(path) < 1e-9);
}

TEST_CASE("Arcs and Bezier curves of a JSON path are given, lines are points") {
  const InputPath path = read_json(R"({"paths": [{"points": [[0,0], [4,0], {"to": [4,6], "centre": [4,3]},
    {"clockwise": true, "centre": [4,0], "to": [10,0]}, {"to": [13,3], "control": [10,1,11,3]}, [20,3]]}]})")
                             .at(0);
  REQUIRE(path.given.size() == 3);
  CHECK(path.given[0].first == 1);
  CHECK_FALSE(path.given[0].clockwise);
  CHECK(path.given[1].clockwise);
  CHECK(path.given[2].kind == GivenCurve::Kind::kBezier);
  CHECK(path.given[2].last + 2 == path.path.points.size());
  CHECK(off_given(path) < 1e-9);
}

TEST_CASE("Arcs of a drawing stay arcs when curves are joined, turned round and mirrored") {
  const auto drawing = [](const std::string& entities) {
    return dxf_lines("0 SECTION 2 ENTITIES") + dxf_lines(entities) + dxf_lines("0 ENDSEC 0 EOF");
  };
  const std::string slot =
      "0 LINE 8 cut 10 0 20 0 11 10 21 0 0 LINE 8 cut 10 0 20 8 11 10 21 8 "
      "0 ARC 8 cut 10 10 20 4 40 4 50 270 51 90 0 ARC 8 cut 10 0 20 4 40 4 50 90 51 270";
  const InputPath path = read_dxf(drawing(slot)).at(0);
  REQUIRE(path.given.size() == 2);
  CHECK_FALSE(path.given[0].clockwise);
  CHECK(off_given(path) < 1e-9);
  // the path starts with its first line, which its arc reaches against its own direction
  const InputPath turned =
      read_dxf(
          drawing("0 LINE 8 0 10 0 20 0 11 4 21 4 0 ARC 8 0 10 0 20 4 40 4 50 270 51 0 0 ARC 8 0 10 0 20 "
                  "-4 40 4 50 90 51 180"))
          .at(0);
  REQUIRE(turned.given.size() >= 1);
  CHECK(off_given(turned) < 1e-9);
  const InputPath bulged =
      read_dxf(drawing("0 LWPOLYLINE 8 0 90 3 70 1 230 -1 10 1 20 0 42 0.5 10 5 20 0 42 -0.2 10 3 20 6"))
          .at(0);
  REQUIRE(bulged.given.size() == 2);
  CHECK(bulged.path.points.front() == Point2{-1, 0});
  CHECK(bulged.given[0].clockwise);  // seen from below
  CHECK_FALSE(bulged.given[1].clockwise);
  CHECK(off_given(bulged) < 1e-9);
}

TEST_CASE("A cubic spline of a drawing is given exactly: a Bezier curve for each span between its knots") {
  RandomStream draw(17, Purpose::kTest);
  for (int trial = 0; trial < 20; ++trial) {
    const BasisSpline spline = random_spline(draw, 2 + int(draw.below(2)), false);
    const InputPath path =
        read_dxf(dxf_lines("0 SECTION 2 ENTITIES " + spline.entity() + " 0 ENDSEC 0 EOF")).at(0);
    REQUIRE(path.given.size() == std::size_t(spline.knots.back()));
    CHECK(beside_given(path) == 0);
    CHECK(off_given(path) < 1e-9);
    for (std::size_t k = 0; k < path.given.size(); ++k)
      for (const double x : {0.1, 0.37, 0.8})
        CHECK(distance(path.given[k].at(x), spline.at(double(k) + x)) < 1e-11);
  }
}

TEST_CASE("Splines that are rational or of a higher degree are given within a nanometre") {
  RandomStream draw(18, Purpose::kTest);
  for (int trial = 0; trial < 6; ++trial) {
    const bool rational = trial % 2 == 0;
    const BasisSpline spline =
        random_spline(draw, rational ? 2 + int(draw.below(3)) : 4 + int(draw.below(2)), rational);
    const InputPath path =
        read_dxf(dxf_lines("0 SECTION 2 ENTITIES " + spline.entity() + " 0 ENDSEC 0 EOF")).at(0);
    CHECK(beside_given(path) == 0);
    CHECK(off_given(path) < 1e-9);
    double most = 0.0;
    for (std::size_t k = 0; k < path.given.size(); k += 1 + path.given.size() / 12)
      for (const double x : {0.21, 0.79}) most = std::max(most, spline.off(path.given[k].at(x)));
    CHECK(most < 1e-6);
  }
}

TEST_CASE("Splines of a drawing stay given when they are joined, turned round and mirrored") {
  const std::string half = "71 3 40 0 40 0 40 0 40 0 40 1 40 1 40 1 40 1 ";
  const InputPath path = read_dxf(dxf_lines("0 SECTION 2 ENTITIES 0 SPLINE 8 0 " + half +
                                            "10 0 20 0 10 3 20 6 10 9 20 5 10 12 20 0 0 SPLINE 8 0 " + half +
                                            "10 24 20 0 10 20 20 -7 10 16 20 -6 10 12 20 0 0 ENDSEC 0 EOF"))
                             .at(0);
  REQUIRE(path.given.size() == 2);
  CHECK(path.given[1].start == Point2{12, 0});
  CHECK(path.given[1].control[0] == Point2{16, -6});
  CHECK(off_given(path) < 1e-9);
  const InputPath below =
      read_dxf(dxf_lines("0 SECTION 2 ENTITIES 0 LINE 8 0 10 -5 20 0 11 -10 21 0 "
                         "0 ELLIPSE 8 0 10 0 20 0 11 5 21 0 40 0.5 41 0 42 3.141592653589793 230 -1 "
                         "0 ENDSEC 0 EOF"))
          .at(0);
  CHECK(all_of(below, GivenCurve::Kind::kBezier));
  CHECK(beside_given(below) == 1);
  CHECK(off_given(below) < 1e-9);
}

TEST_CASE("Ellipses of any size are given within a nanometre, circles as arcs") {
  for (const double radius : {0.5, 30.0, 8000.0}) {
    std::ostringstream entity;
    entity << "0 SECTION 2 ENTITIES 0 ELLIPSE 10 0 20 0 11 " << radius << " 21 0 40 0.25 0 ENDSEC 0 EOF";
    const InputPath path = read_dxf(dxf_lines(entity.str())).at(0);
    CHECK(beside_given(path) == 0);
    CHECK(path.path.points.front() == path.path.points.back());
    double most = 0.0;
    for (const GivenCurve& g : path.given)
      for (double x = 0.05; x < 1.0; x += 0.1) {
        const Point2 p = g.at(x);
        // at most as far from the ellipse as from its point of the same direction
        const double u = p.x_mm / radius, v = p.y_mm / (0.25 * radius);
        most = std::max(most, radius * std::abs(std::sqrt(u * u + v * v) - 1.0));
      }
    CHECK(most < 1e-6);
  }
  const InputPath circle =
      read_dxf(
          dxf_lines("0 SECTION 2 ENTITIES 0 ELLIPSE 10 1 20 2 11 0 21 5 40 1 41 0 42 1.5 0 ENDSEC 0 EOF"))
          .at(0);
  REQUIRE(circle.given.size() == 1);
  CHECK(all_of(circle, GivenCurve::Kind::kArc));
  CHECK(distance(circle.given[0].centre, {1, 2}) < 1e-12);
}

TEST_CASE("SVG's cubic and quadratic curves are given exactly, in every transform") {
  const InputPath path = of_svg(
      "<g transform='rotate(30) scale(1.5 0.7)'><path d='M20 0 C24 9 31 -6 40 5 S52 9 60 0 Q66 9 72 0 T84 0 "
      "H90'/>"
      "</g>");
  REQUIRE(path.given.size() == 4);
  CHECK(all_of(path, GivenCurve::Kind::kBezier));
  CHECK(beside_given(path) == 1);
  CHECK(off_given(path) < 1e-9);
  const double c = std::sqrt(0.75), s = 0.5;
  const Point2 control{c * 1.5 * 24 - s * 0.7 * 9, 100.0 - (s * 1.5 * 24 + c * 0.7 * 9)};
  CHECK(distance(path.given[0].control[0], control) < 1e-12);
}

TEST_CASE("SVG's arcs of circles are arcs where the transform keeps circles, otherwise parts of ellipses") {
  const std::string arc = "<path d='M10 20 A6 6 0 0 1 22 20 A6 6 40 1 0 22 31'/>";
  const InputPath turned = of_svg("<g transform='translate(9 4) rotate(25) scale(1.5)'>" + arc + "</g>");
  REQUIRE(turned.given.size() == 2);
  CHECK(all_of(turned, GivenCurve::Kind::kArc));
  CHECK(turned.given[0].clockwise);  // seen on the page, where y goes down in the file
  CHECK_FALSE(turned.given[1].clockwise);
  CHECK(distance(turned.given[0].centre, turned.path.points.front()) == Approx(9.0));
  CHECK(off_given(turned) < 1e-9);
  const InputPath mirrored = of_svg("<g transform='translate(90 4) scale(-1 1)'>" + arc + "</g>");
  REQUIRE(mirrored.given.size() == 2);
  CHECK_FALSE(mirrored.given[0].clockwise);
  const InputPath flat = of_svg("<g transform='scale(1 0.4)'>" + arc + "</g>");
  CHECK(all_of(flat, GivenCurve::Kind::kBezier));
  CHECK(beside_given(flat) == 0);
  for (const GivenCurve& g : flat.given) {
    const Point2 p = g.at(0.37), centre{16.0, 100.0 - 0.4 * 20.0};
    if (g.last > flat.given[flat.given.size() / 3].first) break;  // of the first arc
    const double u = (p.x_mm - centre.x_mm) / 6.0, v = (p.y_mm - centre.y_mm) / 2.4;
    CHECK(std::abs(std::sqrt(u * u + v * v) - 1.0) < 1e-6 / 6.0);
  }
  const InputPath circle = of_svg("<circle cx='50' cy='50' r='12'/>");
  REQUIRE(circle.given.size() == 2);
  CHECK(all_of(circle, GivenCurve::Kind::kArc));
  CHECK(distance(circle.given[1].centre, {50, 50}) < 1e-12);
}

TEST_CASE("A Bezier curve that is a line is two points") {
  const InputPath svg = of_svg("<path d='M1 1 C2 3 4 7 9 17'/>");
  CHECK(svg.path.points.size() == 2);
  CHECK(svg.given.empty());
  // back and forth on one line it is none
  CHECK(of_svg("<path d='M1 1 C9 17 -3 -7 5 9'/>").path.points.size() > 2);
}

}  // namespace firn
