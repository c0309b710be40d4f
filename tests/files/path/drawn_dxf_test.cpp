// DXF drawings made by a generator: nested blocks of every curve, against the curves themselves.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/grid/random.h"
#include "files/path/path_file.h"
#include "tests/files/path/expected_drawing.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

using test::Affine;

constexpr test::PathReader<read_paths_dxf> read_drawn{"drawn.dxf"};
constexpr double kDrawnDegree = std::numbers::pi / 180.0;

/// Writes a drawing and computes its curves.
class DrawingMaker {
 public:
  explicit DrawingMaker(std::uint64_t seed) : draw_(seed, Purpose::kTest) {}

  std::string text() {
    constexpr double kUnits_mm[][2] = {{0, 1.0}, {1, 25.4}, {4, 1.0}, {5, 10.0}};
    const auto& [code, mm] = kUnits_mm[draw_.below(4)];
    std::ostringstream entities;
    entities.precision(17);
    for (int i = 0; i < 4; ++i) entity(entities, {mm, 0, 0, 0, mm, 0}, true, 0);
    std::ostringstream out;
    out << "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n" << code << "\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n";
    out << "0\nLAYER\n2\nOff\n62\n-3\n0\nLAYER\n2\nPaper\n290\n0\n0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n";
    out << blocks_ << "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" << entities.str() << "0\nENDSEC\n0\nEOF\n";
    return out.str();
  }

  test::ExpectedDrawing expected;

 private:
  double number(double low, double high) { return draw_.uniform(low, high); }
  Point2 place() { return {number(-30.0, 30.0), number(-30.0, 30.0)}; }

  static void group(std::ostream& out, int code, double value) { out << code << '\n' << value << '\n'; }
  static void group(std::ostream& out, int code, Point2 p) {
    group(out, code, p.x_mm);
    group(out, code + 10, p.y_mm);
  }

  /// Begins an entity on a layer of its own, or on a hidden one.
  bool begin(std::ostream& out, const char* type, bool shown) {
    const std::uint32_t kind = draw_.below(6);
    out << "0\n" << type << "\n8\n";
    if (kind == 0)
      out << (draw_.below(2) ? "OFF" : "paper") << '\n';
    else
      out << "layer" << ++layers_ << '\n';
    return shown && kind != 0;
  }

  /// Half of the entities of a plane lie in one that is seen from below.
  Affine plane(std::ostream& out) {
    if (draw_.below(2)) return {};
    out << "210\n0\n220\n0\n230\n-1\n";
    return {-1, 0, 0, 0, 1, 0};
  }

  void entity(std::ostream& out, const Affine& map, bool shown, int depth) {
    switch (draw_.below(depth < 3 ? 8 : 6)) {
      case 0:
        return line(out, map, shown);
      case 1:
        return arc(out, map, shown, true);
      case 2:
        return arc(out, map, shown, false);
      case 3:
        return ellipse(out, map, shown);
      case 4:
        return polyline(out, map, shown);
      case 5:
        return spline(out, map, shown);
      default:
        return insert(out, map, shown, depth);
    }
  }

  void line(std::ostream& out, const Affine& map, bool shown) {
    shown = begin(out, "LINE", shown);
    const Point2 a = place(), b = place();
    group(out, 10, a);
    group(out, 30, number(-1e-12, 1e-12));
    group(out, 11, b);
    if (shown) expected.add({map(a), map(b)});
  }

  void arc(std::ostream& out, const Affine& map, bool shown, bool whole) {
    shown = begin(out, whole ? "CIRCLE" : "ARC", shown);
    const Point2 centre = place();
    const double radius = number(0.5, 20.0), from = number(0.0, 360.0),
                 sweep = whole ? 360.0 : number(5.0, 355.0);
    group(out, 10, centre);
    group(out, 40, radius);
    if (!whole) {
      group(out, 50, from);
      group(out, 51, std::fmod(from + sweep, 360.0));
    }
    const Affine plane = this->plane(out);
    if (shown)
      expected.add(test::after(map, plane), [=](double t) {
        const double angle = (from + t * sweep) * kDrawnDegree;
        return Point2{centre.x_mm + radius * std::cos(angle), centre.y_mm + radius * std::sin(angle)};
      });
  }

  void ellipse(std::ostream& out, const Affine& map, bool shown) {
    shown = begin(out, "ELLIPSE", shown);
    const Point2 centre = place(), major = place();
    const double ratio = number(0.1, 1.0), from = number(0.0, 6.0), sweep = number(0.2, 6.2);
    group(out, 10, centre);
    group(out, 11, major);
    group(out, 40, ratio);
    group(out, 41, from);
    group(out, 42, from + sweep);
    if (shown)
      expected.add(map, [=](double t) {
        const double c = std::cos(from + t * sweep), s = ratio * std::sin(from + t * sweep);
        return Point2{centre.x_mm + c * major.x_mm - s * major.y_mm,
                      centre.y_mm + c * major.y_mm + s * major.x_mm};
      });
  }

  /// An arc by its bulge, and a line to a third vertex.
  void polyline(std::ostream& out, const Affine& map, bool shown) {
    shown = begin(out, "LWPOLYLINE", shown);
    const Point2 centre = place(), last = place();
    const double radius = number(1.0, 15.0), from = number(0.0, 6.0), sweep = number(-5.5, 5.5);
    const auto at = [=](double angle) {
      return Point2{centre.x_mm + radius * std::cos(angle), centre.y_mm + radius * std::sin(angle)};
    };
    group(out, 10, at(from));
    group(out, 42, std::tan(0.25 * sweep));
    group(out, 10, at(from + sweep));
    group(out, 10, last);
    const Affine plane = this->plane(out);
    if (shown)
      expected.add(test::after(map, plane), [=](double t) {
        if (t <= 0.5) return at(from + 2.0 * t * sweep);
        const Point2 a = at(from + sweep);
        const double x = 2.0 * t - 1.0;
        return Point2{(1.0 - x) * a.x_mm + x * last.x_mm, (1.0 - x) * a.y_mm + x * last.y_mm};
      });
  }

  /// A rational Bezier curve of the third degree.
  void spline(std::ostream& out, const Affine& map, bool shown) {
    shown = begin(out, "SPLINE", shown);
    out << "71\n3\n40\n0\n40\n0\n40\n0\n40\n0\n40\n1\n40\n1\n40\n1\n40\n1\n";
    std::vector<Point2> p;
    std::vector<double> w;
    for (int i = 0; i < 4; ++i) {
      p.push_back(place());
      w.push_back(number(0.5, 2.0));
      group(out, 41, w.back());
      group(out, 10, p.back());
    }
    if (shown)
      expected.add(map, [=](double t) {
        const double u = 1.0 - t, b[4] = {u * u * u, 3.0 * t * u * u, 3.0 * t * t * u, t * t * t};
        double x = 0.0, y = 0.0, below = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
          x += b[i] * w[i] * p[i].x_mm;
          y += b[i] * w[i] * p[i].y_mm;
          below += b[i] * w[i];
        }
        return Point2{x / below, y / below};
      });
  }

  /// A new block and its INSERT, in one row or in an array of two columns.
  void insert(std::ostream& out, const Affine& map, bool shown, int depth) {
    out << "0\nINSERT\n8\nlayer" << ++layers_ << "\n2\nBlock" << ++inserts_ << '\n';
    const std::string name = "BLOCK" + std::to_string(inserts_);
    const Point2 base = place(), at = place();
    const double angle = number(-180.0, 180.0), sx = number(0.4, 1.5) * (draw_.below(2) ? 1.0 : -1.0),
                 sy = draw_.below(2) ? sx : number(0.4, 1.5);
    const int columns = 1 + int(draw_.below(2));
    const double step = number(50.0, 60.0);
    group(out, 10, at);
    group(out, 41, sx);
    group(out, 42, sy);
    group(out, 50, angle);
    group(out, 70, columns);
    group(out, 44, step);
    const Affine plane = this->plane(out);
    const double c = std::cos(angle * kDrawnDegree), s = std::sin(angle * kDrawnDegree);
    const RandomStream start = draw_;
    for (int column = 0; column < columns; ++column) {  // the same content each time
      draw_ = start;
      const Affine turn{c, -s, at.x_mm + c * column * step, s, c, at.y_mm + s * column * step};
      const Affine size{sx, 0, -sx * base.x_mm, 0, sy, -sy * base.y_mm};
      std::ostringstream content;
      content.precision(17);
      content << "0\nBLOCK\n2\n" << name << '\n';
      group(content, 10, base);
      const int inserts = inserts_;
      const int n = 1 + int(draw_.below(2));
      for (int i = 0; i < n; ++i)
        entity(content, test::after(map, test::after(plane, test::after(turn, size))), shown, depth + 1);
      if (column + 1 < columns) inserts_ = inserts;
      if (column == 0) blocks_ += content.str() + "0\nENDBLK\n";
    }
  }

  RandomStream draw_;
  std::string blocks_;
  int layers_ = 0, inserts_ = 0;
};

}  // namespace

TEST_CASE("Two hundred drawings of nested blocks have the count, length and bounding box of their curves") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    DrawingMaker maker(seed);
    const std::string text = maker.text();
    CAPTURE(seed);
    if (maker.expected.count == 0)
      CHECK(read_drawn.refusal(text).find("holds no curve") != std::string::npos);
    else
      CHECK(difference(read_drawn(text), maker.expected) == "");
  }
}

}  // namespace firn
