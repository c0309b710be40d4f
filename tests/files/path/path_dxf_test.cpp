// Paths from DXF: curves against closed forms, joined where their ends meet; anything else is named.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "core/grid/random.h"
#include "files/path/join_curves.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

/// "0 LINE 10 1.5" as the lines of a file.
std::string lines(const std::string& words) {
  std::string out = words;
  for (char& c : out)
    if (c == ' ') c = '\n';
  return out + "\n";
}

std::string drawing(const std::string& entities, const std::string& before = "") {
  return (before.empty() ? "" : lines(before)) + lines("0 SECTION 2 ENTITIES") + lines(entities) +
         lines("0 ENDSEC 0 EOF");
}

constexpr test::PathReader<read_paths_dxf> read{"part.dxf"};

std::string refusal(const std::string& text) { return read.refusal(text); }

double length_of(const std::vector<Point2>& p) {
  double length = 0.0;
  for (std::size_t i = 1; i < p.size(); ++i) length += distance(p[i - 1], p[i]);
  return length;
}

}  // namespace

TEST_CASE("A drawing's curves are one path where their ends meet, in any order and direction") {
  const auto paths =
      read(drawing("0 LINE 8 cut 10 0 20 0 11 10 21 0 0 LINE 8 cut 10 0 20 8 11 0 21 0 "
                   "0 ARC 8 cut 10 10 20 4 40 4 50 270 51 90 0 LINE 8 cut 10 0 20 8 11 10 21 8 "
                   "0 LINE 8 other 10 10 20 0 11 20 21 0"));
  REQUIRE(paths.size() == 2);
  const auto& p = paths[0].path.points;
  CHECK(p.front() == p.back());
  CHECK(length_of(p) == Approx(28.0 + 4.0 * std::numbers::pi).epsilon(1e-3));
  int on_arc = 0;
  for (const Point2& q : p)
    if (q.x_mm > 10.0 + 1e-9) {
      ++on_arc;
      CHECK(distance(q, {10, 4}) == Approx(4.0).epsilon(1e-12));
    }
  CHECK(on_arc > 10);
  CHECK(paths[0].place == "part.dxf:6");
  CHECK(paths[1].path.points.size() == 2);
}

TEST_CASE("Random cuts of a closed outline, shuffled and turned, are joined to that outline again") {
  RandomStream draw(5, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 3 + int(draw.below(40));
    std::vector<Point2> outline;
    for (int i = 0; i < n; ++i)
      outline.push_back({20.0 * std::cos(2.0 * std::numbers::pi * i / n) + draw.uniform(-0.1, 0.1),
                         20.0 * std::sin(2.0 * std::numbers::pi * i / n) + draw.uniform(-0.1, 0.1)});
    std::vector<DrawnCurve> curves;
    for (int i = 0; i < n; ++i) {
      Point2 a = outline[std::size_t(i)], b = outline[std::size_t((i + 1) % n)];
      a.x_mm += draw.uniform(-0.3, 0.3) * kJoin_mm;  // as files round
      if (draw.below(2)) std::swap(a, b);
      curves.push_back({{{a, b}, {}}, 1.0, "0", std::size_t(i)});
    }
    for (std::size_t i = curves.size(); i-- > 1;)
      std::swap(curves[i], curves[draw.below(std::uint32_t(i + 1))]);
    std::vector<JoinedCurve> joined;
    join_curves(curves, [&](JoinedCurve&& j) { joined.push_back(std::move(j)); });
    REQUIRE(joined.size() == 1);
    CHECK(joined[0].parts == std::size_t(n));
    CHECK(joined[0].shape.points.size() == std::size_t(n) + 1);
    CHECK(joined[0].shape.points.front() == joined[0].shape.points.back());
    CHECK(length_of(joined[0].shape.points) ==
          Approx(length_of(outline) + distance(outline.front(), outline.back())).epsilon(2e-3));
  }
}

TEST_CASE("A bulge is the tangent of a quarter of its arc's angle") {
  RandomStream draw(6, Purpose::kTest);
  for (int trial = 0; trial < 100; ++trial) {
    const double radius = draw.uniform(0.5, 30.0), angle = draw.uniform(-6.1, 6.1),
                 from = draw.uniform(0.0, 6.0);
    const auto at = [&](double a) { return Point2{3.0 + radius * std::cos(a), -2.0 + radius * std::sin(a)}; };
    const Point2 a = at(from), b = at(from + angle);
    std::ostringstream text;
    text.precision(17);
    text << "0 LWPOLYLINE 90 2 70 0 10 " << a.x_mm << " 20 " << a.y_mm << " 42 " << std::tan(0.25 * angle)
         << " 10 " << b.x_mm << " 20 " << b.y_mm;
    const auto paths = read(drawing(text.str()));
    REQUIRE(paths.size() == 1);
    for (const Point2& p : paths[0].path.points) CHECK(distance(p, {3, -2}) == Approx(radius).epsilon(1e-9));
    CHECK(length_of(paths[0].path.points) == Approx(radius * std::abs(angle)).epsilon(2e-3));
  }
}

TEST_CASE("A closed polyline, old or new, ends where it begins") {
  const auto light = read(drawing("0 LWPOLYLINE 90 3 70 1 38 2.5 10 0 20 0 10 4 20 0 10 4 20 3"));
  const auto old = read(drawing(
      "0 POLYLINE 66 1 70 1 30 2.5 0 VERTEX 10 0 20 0 0 VERTEX 10 4 20 0 0 VERTEX 10 4 20 3 0 SEQEND"));
  const auto space =
      read(drawing("0 POLYLINE 66 1 70 9 0 VERTEX 10 0 20 0 30 2.5 70 32 0 VERTEX 10 4 20 0 30 2.5 "
                   "0 VERTEX 10 4 20 3 30 2.5 0 SEQEND"));
  for (const auto* paths : {&light, &old, &space}) {
    REQUIRE(paths->size() == 1);
    CHECK(paths->front().path.points == std::vector<Point2>{{0, 0}, {4, 0}, {4, 3}, {0, 0}});
    CHECK(paths->front().path.z_mm == 2.5);
  }
}

TEST_CASE("A rational spline of degree two with the weight sqrt(1/2) is a quarter circle") {
  const auto paths = read(
      drawing("0 SPLINE 70 4 71 2 72 6 73 3 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 0.70710678118654752 41 1 "
              "10 10 20 0 30 0 10 10 20 10 30 0 10 0 20 10 30 0"));
  REQUIRE(paths.size() == 1);
  const auto& p = paths[0].path.points;
  CHECK(p.front() == Point2{10, 0});
  CHECK(distance(p.back(), {0, 10}) < 1e-12);
  for (const Point2& q : p) CHECK(distance(q, {}) == Approx(10.0).epsilon(1e-12));
  REQUIRE(paths[0].given.size() == 1);
  CHECK(paths[0].given[0].kind == GivenCurve::Kind::kArc);
  CHECK(distance(paths[0].given[0].centre, {}) < 1e-12);
}

TEST_CASE("A cubic spline without inner knots is the Bezier curve of its control points") {
  const auto paths = read(drawing(
      "0 SPLINE 71 3 40 0 40 0 40 0 40 0 40 2 40 2 40 2 40 2 10 0 20 0 10 3 20 6 10 9 20 6 10 12 20 0"));
  REQUIRE(paths.size() == 1);
  for (const Point2& q : paths[0].path.points) {
    double t = q.x_mm / 12.0;
    for (int i = 0; i < 60; ++i) {  // Newton's method for x(t)
      const double u = 1.0 - t, f = 9.0 * t * u * u + 27.0 * t * t * u + 12.0 * t * t * t - q.x_mm;
      t -= f / (9.0 * u * u + 36.0 * t * u + 9.0 * t * t);
    }
    CHECK(q.y_mm == Approx(18.0 * t * (1.0 - t)).margin(1e-9));
  }
}

TEST_CASE("Every point of an ellipse lies on it, from its first parameter to its last") {
  const auto paths = read(drawing("0 ELLIPSE 10 1 20 2 11 3 21 4 40 0.4 41 0 42 1.5707963267948966"));
  const auto& p = paths.at(0).path.points;
  CHECK(distance(p.front(), {4, 6}) < 1e-12);
  CHECK(distance(p.back(), {1 - 0.4 * 4, 2 + 0.4 * 3}) < 1e-12);
  for (const Point2& q : p) {
    const double u = (0.6 * (q.x_mm - 1) + 0.8 * (q.y_mm - 2)) / 5,
                 v = (-0.8 * (q.x_mm - 1) + 0.6 * (q.y_mm - 2)) / 2;
    CHECK(u * u + v * v == Approx(1.0).margin(1e-6));
  }
}

TEST_CASE("A plane seen from below mirrors x, and the drawing's unit scales everything") {
  const auto paths =
      read(drawing("0 ARC 10 1 20 0 40 1 50 0 51 90 230 -1", "0 SECTION 2 HEADER 9 $INSUNITS 70 1 0 ENDSEC"));
  const auto& p = paths.at(0).path.points;
  CHECK(distance(p.front(), {-2 * 25.4, 0}) < 1e-9);
  CHECK(distance(p.back(), {-25.4, 25.4}) < 1e-9);
}

TEST_CASE("Hidden layers, hidden entities and paper space are not driven") {
  const std::string tables =
      "0 SECTION 2 TABLES 0 TABLE 2 LAYER 70 3 0 LAYER 2 off 70 0 62 -7 0 LAYER 2 frozen 70 1 62 7 "
      "0 LAYER 2 on 70 0 62 7 0 ENDTAB 0 ENDSEC";
  const auto paths =
      read(drawing("0 LINE 8 off 11 1 21 1 0 LINE 8 frozen 11 1 21 1 0 TEXT 8 off 10 1 "
                   "0 LINE 8 on 60 1 11 1 21 1 0 LINE 8 on 67 1 11 1 21 1 0 LINE 8 on 11 5 21 0",
                   tables));
  REQUIRE(paths.size() == 1);
  CHECK(paths[0].path.points.back() == Point2{5, 0});
}

TEST_CASE("A mistake in a DXF file is named with its line") {
  CHECK(refusal(drawing("0 MLINE 8 0 10 1")).find("part.dxf:6: \"MLINE\" is not read") == 0);
  CHECK(refusal(drawing("0 LINE 10 0 11 x")).find("group 11: \"x\" is not a finite number") !=
        std::string::npos);
  CHECK(refusal(drawing("0 LINE 10 0 11 1e9")).find("beyond the limit of +-100000 mm") != std::string::npos);
  CHECK(refusal(drawing("0 LINE 10 0 30 1 11 5")).find("z changes along a path") != std::string::npos);
  CHECK(refusal(drawing("0 POLYLINE 70 8 0 VERTEX 30 1 0 VERTEX 10 3 0 SEQEND")).find("z changes") !=
        std::string::npos);
  CHECK(refusal(drawing("0 POLYLINE 70 16 0 VERTEX 0 SEQEND")).find("mesh") != std::string::npos);
  CHECK(refusal(drawing("0 POLYLINE 0 VERTEX 10 3")).find("without SEQEND") != std::string::npos);
  CHECK(refusal(drawing("0 CIRCLE 40 -1")).find("a radius of -1;") != std::string::npos);
  CHECK(refusal(drawing("0 CIRCLE 40 1 210 1 230 0")).find("normal 1, 0, 0") != std::string::npos);
  CHECK(refusal(drawing("0 SPLINE 71 3")).find("without control points") != std::string::npos);
  CHECK(refusal(drawing("0 SPLINE 71 1 40 0 40 1 40 0 40 1 10 0 10 1")).find("knots must ascend") !=
        std::string::npos);
  CHECK(
      refusal(drawing("0 LINE 11 5", "0 SECTION 2 HEADER 9 $INSUNITS 70 7 0 ENDSEC")).find("$INSUNITS = 7") !=
      std::string::npos);
  CHECK(refusal(drawing("0 POINT 10 1")).find("holds no curve") != std::string::npos);
  CHECK(refusal(lines("0 SECTION 2 ENTITIES 0 LINE 11 5")).find("ends before EOF") != std::string::npos);
  CHECK(refusal("AutoCAD Binary DXF\r\n").find("binary") != std::string::npos);
  CHECK(refusal("hello\nworld\n").find("\"hello\" is not a group code") != std::string::npos);
}

TEST_CASE("A sweep that is a turn but for the file's rounding is a full turn") {
  for (const char* to : {"6.28319", "6.28318", "6.28318530718", "6.283185307179586", "6.2832"}) {
    INFO(to);
    const auto paths = read(drawing(std::string("0 ELLIPSE 11 10 21 0 40 0.5 41 0 42 ") + to));
    const auto& p = paths.at(0).path.points;
    CHECK(p.front() == p.back());
    CHECK(length_of(p) == Approx(48.4422).epsilon(1e-4));
  }
  const char* kTurns[][2] = {{"0", "360.0001"},  {"0", "359.9999"},     {"45", "45"},
                             {"90.0", "450.00"}, {"0.00001", "0.0000"}, {"12.34567", "12.34568"}};
  for (const auto& [from, to] : kTurns) {
    INFO(from << " to " << to);
    const auto paths = read(drawing(std::string("0 ARC 40 2 50 ") + from + " 51 " + to));
    CHECK(length_of(paths.at(0).path.points) == Approx(4.0 * std::numbers::pi).epsilon(2e-3));
    CHECK(paths[0].path.points.front() == paths[0].path.points.back());
  }
}

TEST_CASE("A short arc across the angle 0 is no full turn") {
  const auto paths = read(drawing("0 ARC 40 1000 50 359.99 51 0.01"));
  CHECK(length_of(paths.at(0).path.points) == Approx(1000.0 * 0.02 * std::numbers::pi / 180.0).epsilon(1e-6));
}

TEST_CASE("Curves of length 0 are left out and named") {
  const auto noted = read.notes(drawing("0 LINE 11 5 0 LINE 10 3 11 3 0 LWPOLYLINE 10 1 20 1 10 1 20 1"));
  REQUIRE(noted.size() == 1);
  CHECK(noted[0] == "part.dxf: 2 of length 0 left out, the first in line 10");
  CHECK(refusal(drawing("0 LINE 10 3 11 3")).find("1 of length 0 left out, the first in line 6") !=
        std::string::npos);
}

TEST_CASE("Heights that differ by less than a micrometre are one height, and near 0 they are 0") {
  const auto paths = read(drawing(
      "0 LINE 10 0 20 0 30 0 11 10 21 0 31 1e-17 0 LINE 10 10 20 0 30 3.89e-16 11 10 21 10 31 3.89e-16 "
      "0 POLYLINE 70 8 0 VERTEX 10 10 20 10 30 -2e-16 0 VERTEX 10 0 20 10 30 0 0 SEQEND "
      "0 SPLINE 71 1 40 0 40 0 40 1 40 1 10 0 20 10 30 1e-12 10 0 20 0 30 0"));
  REQUIRE(paths.size() == 1);
  CHECK(length_of(paths[0].path.points) == Approx(40.0));
  CHECK(paths[0].path.z_mm == 0.0);
  CHECK(refusal(drawing("0 LINE 11 5 31 0.002")).find("z changes along a path, by 0.002 mm") !=
        std::string::npos);
}

TEST_CASE("Layers are known by name whatever its case, and what is not plotted is not driven") {
  const std::string tables =
      "0 SECTION 2 TABLES 0 TABLE 2 LAYER 0 LAYER 2 Frozen 70 1 62 7 290 1 0 LAYER 2 NoPlot 70 0 62 7 290 0 "
      "0 LAYER 2 Defpoints 70 0 62 7 290 1 0 ENDTAB 0 ENDSEC";
  const auto paths =
      read(drawing("0 LINE 8 FROZEN 11 1 0 LINE 8 noplot 11 2 0 LINE 8 DEFPOINTS 11 3 0 LINE 8 a 11 4 0 LINE "
                   "8 A 10 4 11 9",
                   tables));
  REQUIRE(paths.size() == 1);
  CHECK(length_of(paths[0].path.points) == Approx(9.0));
}

TEST_CASE("An imperial drawing without a unit is taken as mm, and that is noted") {
  const std::string line = "0 LINE 11 1";
  const auto noted = read.notes(drawing(line, "0 SECTION 2 HEADER 9 $MEASUREMENT 70 0 0 ENDSEC"));
  REQUIRE(noted.size() == 1);
  CHECK(noted[0].find("$MEASUREMENT says imperial") != std::string::npos);
  CHECK(read.notes(drawing(line, "0 SECTION 2 HEADER 9 $MEASUREMENT 70 1 0 ENDSEC")).empty());
  const std::string inch = "0 SECTION 2 HEADER 9 $MEASUREMENT 70 0 9 $INSUNITS 70 1 0 ENDSEC";
  CHECK(read.notes(drawing(line, inch)).empty());
  CHECK(length_of(read(drawing(line, inch)).at(0).path.points) == Approx(25.4));
}

TEST_CASE("Entities that draw no curve are passed over and counted") {
  const std::string blocks = "0 SECTION 2 BLOCKS 0 BLOCK 2 b 0 ATTDEF 1 x 0 TEXT 1 y 0 ENDBLK 0 ENDSEC";
  const auto noted =
      read.notes(drawing("0 LINE 11 5 0 HATCH 10 0 0 MTEXT 1 a 0 INSERT 66 1 2 B 0 ATTRIB 1 x 0 SEQEND 0 "
                         "DIMENSION 2 *D1 0 HATCH",
                         blocks));
  REQUIRE(noted.size() == 1);
  CHECK(noted[0] == "part.dxf: passed over: 1 ATTDEF, 1 ATTRIB, 1 DIMENSION, 2 HATCH, 1 MTEXT, 1 TEXT");
}

TEST_CASE("A block is scaled, turned, repeated and mirrored about its base point") {
  const std::string blocks =
      "0 SECTION 2 BLOCKS 0 BLOCK 8 0 2 B1 70 0 10 1 20 1 30 0.5 0 LINE 10 1 20 1 30 0.5 11 11 21 1 31 0.5 "
      "0 ENDBLK 8 0 0 BLOCK 2 outer 0 INSERT 2 b1 10 5 0 ENDBLK 0 ENDSEC";
  const auto ends = [&](const std::string& insert) {
    const auto paths = read(drawing("0 INSERT " + insert, blocks));
    std::vector<Point2> out;
    for (const InputPath& p : paths) out.insert(out.end(), {p.path.points.front(), p.path.points.back()});
    return out;
  };
  CHECK(ends("2 B1 10 20 20 20 41 2 42 2 50 90") == std::vector<Point2>{{20, 20}, {20, 40}});
  CHECK(ends("2 b1 10 3 20 4 230 -1") == std::vector<Point2>{{-3, 4}, {-13, 4}});
  CHECK(ends("2 B1 41 -1 71 2 45 7") == std::vector<Point2>{{0, 0}, {-10, 0}, {0, 7}, {-10, 7}});
  CHECK(ends("2 B1 50 180 70 2 44 20") == std::vector<Point2>{{0, 0}, {-10, 0}, {-20, 0}, {-30, 0}});
  CHECK(ends("2 OUTER 41 3") == std::vector<Point2>{{15, 0}, {45, 0}});
  CHECK(read(drawing("0 INSERT 2 B1 30 1 43 2", blocks)).at(0).path.z_mm == 1.0);
}

TEST_CASE("A circle of a block that is scaled unequally is an ellipse, and so is a bulge") {
  const std::string blocks =
      "0 SECTION 2 BLOCKS 0 BLOCK 2 c 0 CIRCLE 40 1 0 ENDBLK "
      "0 BLOCK 2 p 0 LWPOLYLINE 70 1 10 1 20 0 42 1 10 -1 20 0 42 1 0 ENDBLK 0 ENDSEC";
  for (const char* name : {"c", "p"}) {
    INFO(name);
    const auto paths = read(drawing(std::string("0 INSERT 41 10 42 5 50 30 2 ") + name, blocks));
    const auto& p = paths.at(0).path.points;
    CHECK(length_of(p) == Approx(48.4422).epsilon(1e-4));
    CHECK(p.front() == p.back());
    CHECK(!paths[0].given.empty());
  }
  const auto round = read(drawing("0 INSERT 41 10 42 -10 2 p", blocks));
  REQUIRE(round.at(0).given.size() == 2);
  CHECK(round[0].given[0].kind == GivenCurve::Kind::kArc);
  CHECK(round[0].given[0].clockwise);
}

TEST_CASE("Entities of a block on layer 0 lie on the layer of its INSERT, and a frozen one hides all") {
  const std::string before =
      "0 SECTION 2 TABLES 0 LAYER 2 off 62 -1 0 LAYER 2 frozen 70 1 0 ENDSEC 0 SECTION 2 BLOCKS "
      "0 BLOCK 2 b 0 LINE 8 0 11 1 0 LINE 8 own 11 2 21 3 0 ENDBLK 0 ENDSEC";
  const auto count = [&](const std::string& layer) {
    return read(drawing("0 LINE 8 x 11 9 0 INSERT 2 b 10 50 8 " + layer, before)).size();
  };
  CHECK(count("on") == 3);
  CHECK(count("off") == 2);
  CHECK(count("frozen") == 1);
}

TEST_CASE("What is wrong with a block is named") {
  const auto says = [](const std::string& entities, const std::string& blocks, const std::string& words) {
    const std::string said = refusal(drawing(entities, "0 SECTION 2 BLOCKS " + blocks + " 0 ENDSEC"));
    INFO(said);
    CHECK(said.find(words) != std::string::npos);
  };
  says("0 INSERT 2 a", "0 BLOCK 2 b 0 ENDBLK", "block \"a\", which the file does not define");
  says("0 INSERT 2 a", "0 BLOCK 2 a 0 INSERT 2 a 0 ENDBLK", "block \"a\" inserts itself");
  says("0 INSERT 2 a", "0 BLOCK 2 a 70 4 1 other.dwg 0 ENDBLK", "drawn in another file");
  says("0 INSERT 2 a 41 0", "0 BLOCK 2 a 0 ENDBLK", "a scale of 0");
  says("0 INSERT 2 a 70 32767 71 32767", "0 BLOCK 2 a 0 ENDBLK", "more than 1000000 blocks");
  says("0 INSERT 2 a 210 1 230 0", "0 BLOCK 2 a 0 ENDBLK", "normal 1, 0, 0");
}

TEST_CASE("A spline by fit points passes them with one tangent and one curvature at each") {
  const auto paths = read(drawing("0 SPLINE 71 3 74 4 11 0 21 0 11 10 21 5 11 20 21 -5 11 30 21 0"));
  REQUIRE(paths.size() == 1);
  const auto& given = paths[0].given;
  REQUIRE(given.size() == 3);
  const Point2 kFit[] = {{0, 0}, {10, 5}, {20, -5}, {30, 0}};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(distance(given[i].at(0.0), kFit[i]) < 1e-12);
    CHECK(distance(given[i].at(1.0), kFit[i + 1]) < 1e-12);
    if (i > 0) CHECK(distance(given[i].bend(0.0), given[i - 1].bend(1.0)) < 1e-12);
  }
  CHECK(distance(given[0].bend(0.0), {}) < 1e-12);
  CHECK(distance(given[2].bend(1.0), {}) < 1e-12);
}

TEST_CASE("The tangents of a spline by fit points, and a closed one, are kept") {
  const auto tangent = read(drawing("0 SPLINE 71 3 11 0 21 0 11 10 21 0 12 0 22 3 13 0 23 -3"));
  const GivenCurve& c = tangent.at(0).given.at(0);
  CHECK(distance(c.control[0], {0, 10.0 / 3.0}) < 1e-12);
  CHECK(distance(c.control[1], {10, 10.0 / 3.0}) < 1e-12);
  const auto closed = read(drawing("0 SPLINE 70 1 11 1 21 0 11 0 21 1 11 -1 21 0 11 0 21 -1"));
  const auto& g = closed.at(0).given;
  REQUIRE(g.size() == 4);
  CHECK(closed[0].path.points.front() == closed[0].path.points.back());
  for (std::size_t i = 0; i < 4; ++i) CHECK(distance(g[i].bend(0.0), g[(i + 3) % 4].bend(1.0)) < 1e-12);
}

}  // namespace firn
