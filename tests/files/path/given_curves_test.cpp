// Arcs and Bezier curves of path files are carried as such: every sample of one lies on it.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
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

}  // namespace firn
