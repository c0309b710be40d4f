// Paths from G-code: every word that is known, in both units and both ways of counting; the others are named.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "files/path/path_file.h"
#include "files/usage_error.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_gcode> read_gcode{"part.nc"};

std::string gcode_refusal(const std::string& text) { return read_gcode.refusal(text); }

}  // namespace

TEST_CASE("G0 ends a path, G1 goes on, and comments, line numbers and lower case do not matter") {
  const auto paths =
      read_gcode("%\nN10 g21 g90 (start)\nG0 X1 Y2 ; travel\nG1 X3.5 F600\nY4\nG0 X0 Y0\nG1 X1\nM2\n");
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].path.points == std::vector<Point2>{{1, 2}, {3.5, 2}, {3.5, 4}});
  CHECK(paths[0].place == "part.nc:4");
  CHECK(paths[0].speed_limit.point_mm_s == std::vector<double>{10, 10, 10});
  CHECK(paths[1].path.points == std::vector<Point2>{{0, 0}, {1, 0}});
  CHECK(paths[1].number == 2);
}

TEST_CASE("Inches and relative words") {
  const auto paths = read_gcode("G20 G0 X1\nG91 G1 X1 Y-0.5\nG21 X1\n");
  REQUIRE(paths.size() == 1);
  CHECK(paths[0].path.points[0].x_mm == Approx(25.4));
  CHECK(paths[0].path.points[1].x_mm == Approx(50.8));
  CHECK(paths[0].path.points[1].y_mm == Approx(-12.7));
  CHECK(paths[0].path.points[2].x_mm == Approx(51.8));
}

TEST_CASE("Every point of an arc lies on its circle, by I and J as by R, either way round") {
  for (const char* text : {"G0 X10 Y0\nG3 X0 Y10 I-10 J0", "G0 X10 Y0\nG3 X0 Y10 R10",
                           "G0 X10 Y0\nG2 X0 Y10 R-10", "G0 X10 Y0\nG2 X10 Y0 I-10"}) {
    const auto paths = read_gcode(text);
    REQUIRE(paths.size() == 1);
    INFO(text);
    const Point2 centre{0, 0};
    double length = 0.0;
    const auto& p = paths[0].path.points;
    for (std::size_t i = 0; i < p.size(); ++i) {
      CHECK(std::abs(distance(p[i], centre) - 10.0) < 1e-9);
      if (i > 0) length += distance(p[i - 1], p[i]);
    }
    const double quarter = 5.0 * std::numbers::pi;
    const bool far = std::string(text).find("R-10") != std::string::npos;  // the long way round
    const double whole = p.front() == p.back() ? 4.0 * quarter : far ? 3.0 * quarter : quarter;
    CHECK(std::abs(length - whole) < 0.01 * whole);
  }
}

TEST_CASE("G5 is a cubic Bezier curve: its ends, and its middle by de Casteljau") {
  const auto p = read_gcode("G0 X0 Y0\nG5 I0 J3 P0 Q-3 X4 Y0\n").at(0).path.points;
  CHECK(p.back() == Point2{4, 0});
  double highest = 0.0;
  for (const Point2& q : p) highest = std::max(highest, q.y_mm);
  CHECK(highest < -1e-9 + 0.9);  // control points at heights 3 and -3: the curve swings both ways
  CHECK(highest > 0.8);
}

TEST_CASE("Where the feed changes, the slower feed holds on its own line and little of the faster one") {
  const auto path = read_gcode("G0 X0\nG1 X10 F6000\nX20 F600\nX30 F6000\n").at(0);
  const auto& p = path.path.points;
  const auto& speed = path.speed_limit.point_mm_s;
  REQUIRE(speed.size() == p.size());
  for (std::size_t i = 0; i + 1 < p.size(); ++i) {
    const double limit = std::min(speed[i], speed[i + 1]), middle = 0.5 * (p[i].x_mm + p[i + 1].x_mm);
    INFO(middle);
    if (middle > 10.0 && middle < 20.0) CHECK(limit == 10.0);
    if (middle < 9.4 || middle > 20.6) CHECK(limit == 100.0);
    CHECK(limit <= 100.0);
  }
}

TEST_CASE("A height is the path's own, and one that changes along a path is refused") {
  const auto paths = read_gcode("G1 X0 Y0 Z0.2\nG0 Z0.5\nG1 X5\nG0 Z1\nG1 X9\n");
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].path.z_mm == 0.5);
  CHECK(paths[1].path.z_mm == 1.0);
  CHECK(gcode_refusal("G0 X0 Y0 Z0\nG1 X5 Z1\n").find("part.nc:2: z changes along a path") == 0);
}

TEST_CASE("Words need no blanks between them, blanks may follow a letter, and a checksum is no word") {
  const auto paths = read_gcode("G0X0Y0\nG1X10Y2.5F600*71\nG 1 X 11 Y +3\r\n");
  REQUIRE(paths.size() == 1);
  CHECK(paths[0].path.points == std::vector<Point2>{{0, 0}, {10, 2.5}, {11, 3}});
}

TEST_CASE("Words of a printer's firmware are no coordinates") {
  const auto paths = read_gcode(
      "M104 S200\nM201 X500 Y500\nM92 X80\nM84 X Y E\nM117 Hello (there\nG28\nG92 E0\nG1 X5 Y6 F3000\n"
      "G1 X9 E1.2\nM204 P800 X3\nG1 Y8 M106 S255\n");
  REQUIRE(paths.size() == 1);
  CHECK(paths[0].path.points == std::vector<Point2>{{5, 6}, {9, 6}});
}

TEST_CASE("A dwell, a stop and a tool change end a path and move nothing") {
  const auto paths = read_gcode("G0 X0 Y0\nG1 X1\nG4 X2.5\nX2\nM0\nX3\nT2 M6\nX4\n");
  REQUIRE(paths.size() == 4);
  for (std::size_t k = 0; k < 4; ++k)
    CHECK(paths[k].path.points == std::vector<Point2>{{double(k), 0}, {double(k + 1), 0}});
}

TEST_CASE("G92 renames the present place, G92.1 takes it back, and the path goes on") {
  const auto path = read_gcode("G0 X10 Y20\nG92 X0 Y0\nG1 X5\nG3 X5 Y10 I0 J5\nG92.1\nG1 X10 Y20\n").at(0);
  CHECK(path.path.points.front() == Point2{10, 20});
  CHECK(path.path.points[1] == Point2{15, 20});
  REQUIRE(path.given.size() == 1);
  CHECK(path.given[0].centre == Point2{15, 25});
  CHECK(path.path.points[path.given[0].last] == Point2{15, 30});
  CHECK(path.path.points.back() == Point2{10, 20});
}

TEST_CASE("After G28 the first move places the tool, and one of no known start is refused") {
  const auto paths = read_gcode("G0 X1 Y1\nG1 X2\nG91 G28 Z0\nG90\nX3\nG28\nG0 Z5\nG1 X7 Y7\nX8\n");
  REQUIRE(paths.size() == 3);
  CHECK(paths[1].path.points == std::vector<Point2>{{2, 1}, {3, 1}});
  CHECK(paths[2].path.points == std::vector<Point2>{{7, 7}, {8, 7}});
  CHECK(gcode_refusal("G28\nG91 G1 X1\n").find("part.nc:2: G91 after G28") == 0);
  CHECK(gcode_refusal("G28\nG2 X1 Y1 R1\n").find("part.nc:2: an arc or a spline after G28") == 0);
}

TEST_CASE("Centres may be absolute, and a further G5 goes on as the one before ended") {
  const auto path = read_gcode("G90.1\nG0 X10 Y0\nG3 X0 Y10 I0 J0\nG91.1\nG3 X-10 Y0 I0 J-10\n").at(0);
  REQUIRE(path.given.size() == 2);
  for (const GivenCurve& arc : path.given) CHECK(distance(arc.centre, {0, 0}) < 1e-12);
  const auto spline = read_gcode("G0 X0 Y0\nG5 I1 J2 P-1 Q-3 X4 Y0\nG5 P0 Q1 X8 Y0\n").at(0);
  REQUIRE(spline.given.size() == 2);
  CHECK(spline.given[1].control[0] == Point2{5, 3});
  CHECK(gcode_refusal("G0 X0 Y0\nG5 P0 Q1 X8 Y0\n").find("G5 needs both I and J") != std::string::npos);
}

TEST_CASE("The program ends at M2, M30, M99 and at its second %") {
  for (const char* end : {"M2", "M30", "M99", "%"}) {
    INFO(end);
    const auto paths = read_gcode(std::string("%\nO1000 (part)\nG0 X0 Y0\nG1 X1\n") + end + "\nX2 #1=3\n");
    REQUIRE(paths.size() == 1);
    CHECK(paths[0].path.points.size() == 2);
  }
}

TEST_CASE("What a controller would compute or turn is refused, not misread") {
  CHECK(gcode_refusal("#1=5\nG1 X#1\n").find("part.nc:1: parameters and expressions") == 0);
  CHECK(gcode_refusal("G1 X[1+2]\n").find("part.nc:1: parameters and expressions") == 0);
  CHECK(gcode_refusal("o100 sub\n").find("part.nc:1: O-words") == 0);
  CHECK(gcode_refusal("O<part> call\n").find("part.nc:1: O-words") == 0);
  CHECK(gcode_refusal("G1 X1\nM98 P100\n").find("part.nc:2: M98") == 0);
  CHECK(gcode_refusal("G1 X1\nG1 X2 A90\n").find("part.nc:2: A90: only the axes X, Y and Z") == 0);
  CHECK(gcode_refusal("G0 X1 Y0\nG2 X1 Y0 I-1 P3\n").find("several turns") != std::string::npos);
  CHECK(gcode_refusal("G1 X1 X2\n").find("X stands twice") != std::string::npos);
  CHECK(gcode_refusal("G0 G1 X1\n").find("two motions") != std::string::npos);
  CHECK(gcode_refusal("G1 X1\nG80\nX2\n").find("part.nc:3: a coordinate without G0") == 0);
  CHECK(gcode_refusal("G93 G1 X1 F2\n").find("G93 (inverse time feed) is not known here") !=
        std::string::npos);
  CHECK(gcode_refusal("G1 Xnan\n").find("finite number") != std::string::npos);
}

TEST_CASE("What is not known is named with its line and limit") {
  CHECK(gcode_refusal("G1 X1\nG18\n").find("part.nc:2: G18 (the plane ZX) is not known here") == 0);
  CHECK(gcode_refusal("G1 X1\nG41 D1\n").find("part.nc:2: G41") == 0);
  CHECK(gcode_refusal("G1 Xabc\n").find("part.nc:1: X") == 0);
  CHECK(gcode_refusal("G1 X1 F0\n").find("F must be above 0") != std::string::npos);
  CHECK(gcode_refusal("G2 X1 Y1\n").find("needs I and J, or R") != std::string::npos);
  CHECK(gcode_refusal("G0 X0 Y0\nG2 X10 Y0 I1 J0\n").find("radius") != std::string::npos);
  CHECK(gcode_refusal("G0 X0 Y0\nG2 X10 Y0 R1\n").find("does not reach") != std::string::npos);
  CHECK(gcode_refusal("G1 X1000000000\n").find("limit of +-100000 mm") != std::string::npos);
  CHECK(gcode_refusal("(nothing\n").find("a comment without its )") != std::string::npos);
  CHECK(gcode_refusal("G21\n").find("holds no path") != std::string::npos);
  CHECK(gcode_refusal("!\n").find("no word of G-code") != std::string::npos);
}

}  // namespace firn
