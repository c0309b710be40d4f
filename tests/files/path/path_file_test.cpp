#include "files/path/path_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "core/grid/random.h"
#include "files/usage_error.h"

using namespace firn;
using Catch::Contains;

namespace {

using Reader = void (*)(std::istream&, const std::string&, double, const PathSink&);

std::vector<InputPath> paths_of(Reader reader, const std::string& text) {
  std::istringstream in(text);
  std::vector<InputPath> paths;
  reader(in, "job", double(text.size()), [&](InputPath&& p) {
    CHECK(p.fraction > 0.0);
    CHECK(p.fraction <= 1.0);
    paths.push_back(std::move(p));
  });
  return paths;
}
std::string mistake(Reader reader, const std::string& text) {
  try {
    paths_of(reader, text);
  } catch (const UsageError& e) {
    return e.what();
  }
  return "";
}
std::string csv(const std::string& text) { return mistake(read_paths_csv, text); }
std::string json(const std::string& text) { return mistake(read_paths_json, text); }

}  // namespace

TEST_CASE("CSV: a header, a point per line, a blank line between paths, a speed where there is one") {
  const auto paths = paths_of(
      read_paths_csv, "\xef\xbb\xbfx_mm,y_mm,speed_mm_s\r\n0,0,\r\n1.5, -2e1,50\r\n\r\n\r\n3,4,10\r\n5,6,20");
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].path.points == std::vector<Point2>{{0, 0}, {1.5, -20}});
  CHECK(std::isinf(paths[0].speed_limit.point_mm_s[0]));
  CHECK(paths[0].speed_limit.point_mm_s[1] == 50.0);
  CHECK(paths[0].place == "job:2");
  CHECK(paths[1].place == "job:6");
  CHECK(paths[1].number == 2);
  CHECK(paths[1].path.points[1] == Point2{5, 6});
  CHECK(paths_of(read_paths_csv, "x_mm,y_mm\n1,2\n")[0].speed_limit.point_mm_s.empty());
}

TEST_CASE("CSV: every mistake names the line and the limit") {
  CHECK_THAT(csv(""), Contains("job:1") && Contains("x_mm,y_mm"));
  CHECK_THAT(
      csv("x\x1b[2J\xff\n1,2\n"),
      Contains("header must be") && Contains("column 'x?[2J?' is not known"));  // a terminal may show it
  CHECK_THAT(csv("x,r\n1,2\n"), Contains("job:1") && Contains("column 'r' is not known"));
  CHECK_THAT(csv("x_mm,y_mm\n"), Contains("holds no points"));
  CHECK_THAT(csv("x_mm,y_mm\n1,2\n1\n"), Contains("job:3") && Contains("1 columns, the header has 2"));
  CHECK_THAT(csv("x_mm,y_mm\n1,2,3,4,5\n"), Contains("job:2") && Contains("5 columns, the header has 2"));
  CHECK_THAT(csv("x_mm,y_mm\n1,zwei\n"),
             Contains("job:2") && Contains("y_mm = zwei") && Contains("finite number"));
  CHECK_THAT(csv("x_mm,y_mm\nnan,0\n"), Contains("x_mm = nan"));
  CHECK_THAT(csv("x_mm,y_mm\n1e6,0\n"), Contains("beyond the limit of +-100000 mm"));
  CHECK_THAT(csv("x_mm,y_mm,speed_mm_s\n1,0,-5\n"), Contains("speed_mm_s must be above 0"));
  CHECK_THAT(csv("x_mm,y_mm\n" + std::string(2000, '1')),
             Contains("job:2") && Contains("limit of 1000 bytes"));
}

TEST_CASE("CSV: a column yaw_deg turns the tool, behind the speed or without it") {
  const auto with_speed =
      paths_of(read_paths_csv, "x_mm,y_mm,speed_mm_s,yaw_deg\n0,0,,90\n1,0,50,-180\n\n3,3,,0\n");
  REQUIRE(with_speed.size() == 2);
  CHECK(with_speed[0].yaw_point_rad ==
        std::vector<double>{90 * std::numbers::pi / 180.0, -180 * std::numbers::pi / 180.0});
  CHECK(with_speed[0].speed_limit.point_mm_s[1] == 50.0);
  CHECK(with_speed[1].yaw_point_rad.size() == 1);
  const auto alone = paths_of(read_paths_csv, "x_mm,y_mm,yaw_deg\n0,0,1\n1,0,2\n");
  CHECK(alone[0].speed_limit.point_mm_s.empty());
  CHECK(alone[0].yaw_point_rad.size() == 2);
  CHECK_THAT(csv("x_mm,y_mm,yaw_deg\n0,0,\n"),
             Contains("job:2") && Contains("yaw_deg = : is not a finite number"));
  CHECK_THAT(csv(std::string("0,0\n1,\0001\n", 9)),
             Contains("job:2") && Contains("y_mm = ?1: is not a finite"));
  CHECK_THAT(csv("x_mm,y_mm,yaw_deg\n0,0,1e9\n"), Contains("beyond the limit of +-7200"));
}

TEST_CASE(
    "CSV: columns in any order and unit, as headers spell them, two in mm without a header, after commas, "
    "semicolons or tabs") {
  const auto first = [](const std::string& text) { return paths_of(read_paths_csv, text).at(0); };
  CHECK(first("1,2\n3.5,-4e1\n").path.points == std::vector<Point2>{{1, 2}, {3.5, -40}});
  CHECK(first("1,2\n3,4\n").place == "job:1");
  CHECK(first("x_mm;y_mm\n1.5;2\n").path.points == std::vector<Point2>{{1.5, 2}});
  CHECK(first("1.5\t2\n3\t4\n").path.points == std::vector<Point2>{{1.5, 2}, {3, 4}});
  CHECK(first("y_cm,x_in\n1,1\n").path.points == std::vector<Point2>{{25.4, 10}});
  CHECK(first("X [mm],Y (mm)\n1,2\n").path.points == std::vector<Point2>{{1, 2}});
  CHECK(first("\"x_um\",\"y_m\"\n500,0.25\n").path.points == std::vector<Point2>{{0.5, 250}});
  const InputPath all = first("yaw_rad,z_mm,x_mm,y_mm,speed_mm/min\n0.5,3,1,2,600\n-0.5,3,2,2,\n");
  CHECK(all.path.z_mm == 3.0);
  CHECK(all.yaw_point_rad[0] == Approx(0.5).epsilon(1e-15));
  CHECK(all.speed_limit.point_mm_s[0] == Approx(10.0));
  CHECK(std::isinf(all.speed_limit.point_mm_s[1]));
  CHECK_THAT(csv("x_mm,y_mm,z_mm\n0,0,1\n1,0,2\n"), Contains("job:3: z changes along a path"));
  CHECK_THAT(csv("x_mm,x_um,y_mm\n1,2,3\n"), Contains("columns 'x_mm' and 'x_um' are both x"));
  CHECK_THAT(csv("x_mm,speed_mm_s\n1,2\n"), Contains("there is no column y"));
  CHECK_THAT(csv("x_mm,y_ell\n1,2\n"), Contains("header must be") && Contains("_in"));
}

TEST_CASE(
    "CSV: a third column without a header is z_mm, and one that changes along a path is asked for its name") {
  const auto paths = paths_of(read_paths_csv, "1;2;30\n3;4;30\n\n5;6;-1.5\n");
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].path.points == std::vector<Point2>{{1, 2}, {3, 4}});
  CHECK(paths[0].path.z_mm == 30.0);
  CHECK(paths[1].path.z_mm == -1.5);
  CHECK_THAT(csv("1,2,0\n3,4,90\n"), Contains("job:2") && Contains("third column") && Contains("is z_mm") &&
                                         Contains("name it") && Contains("yaw_deg") &&
                                         Contains("speed_mm_s"));
  CHECK_THAT(csv("1,2,3\n4,5\n"), Contains("job:2: 2 columns"));
  CHECK_THAT(csv("1,2,3,4\n"),
             Contains("two columns, x_mm and y_mm, or three, with z_mm") && Contains("yaw_deg"));
}

TEST_CASE("JSON: yaw_deg is a number for the path or a list with one per point, before or after the points") {
  const auto paths = paths_of(read_paths_json, R"({"paths": [{"points": [[0,0],[1,0]], "yaw_deg": [0, 720]},
    {"yaw_deg": [10, 20, 30], "points": [[0,0],[1,0],[2,0]]}, {"points": [[0,0]], "yaw_deg": -45}]})");
  REQUIRE(paths.size() == 3);
  CHECK(paths[0].yaw_point_rad[1] == Approx(4.0 * std::numbers::pi));
  CHECK(paths[1].yaw_point_rad.size() == 3);
  CHECK(paths[2].yaw_point_rad.empty());
  CHECK(paths[2].yaw_rad == Approx(-0.25 * std::numbers::pi));
  const auto in_path = [](const std::string& body) {
    return json("{\"paths\": [{\"points\": [[0,0],[1,1]], " + body + "}]}");
  };
  CHECK_THAT(in_path("\"yaw_deg\": [1]"), Contains("paths[0]: yaw_deg has 1 entries, points 2"));
  CHECK_THAT(in_path("\"yaw_deg\": [1, null]"), Contains("paths[0].yaw_deg[1]: must be a number, not null"));
  CHECK_THAT(in_path("\"yaw_deg\": [1, 1e9]"),
             Contains("paths[0].yaw_deg[1]") && Contains("must lie in [-7200"));
  CHECK_THAT(in_path("\"yaw_deg\": \"a\""), Contains("a number, or one list"));
}

TEST_CASE("JSON: all keys of a path are read, in any order") {
  const auto paths = paths_of(read_paths_json, R"({"version": 1, "paths": [
    {"points": [[0, 0], [1.5, -20.0, 50], [3, 4, null]], "closed": true, "kind": "measurement", "layer": 7, "material": 1,
     "width_mm": 1.5, "layer_height_mm": 0.25, "z_mm": 31.25, "yaw_deg": 90, "tool": "laser", "speed_mm_s": 50},
    {"points": [[1, 1]]}]})");
  REQUIRE(paths.size() == 2);
  const InputPath& p = paths[0];
  CHECK(p.path.points.size() == 3);
  CHECK(p.path.closed);
  CHECK(p.path.kind == PathKind::kMeasurement);
  CHECK(p.path.layer == 7);
  CHECK(p.path.material == 1);
  CHECK(p.path.width_mm == 1.5);
  CHECK(p.path.layer_height_mm == 0.25);
  CHECK(p.path.z_mm == 31.25);
  CHECK(p.yaw_rad == Approx(1.5707963267948966));
  CHECK(p.tool == "laser");
  CHECK(p.speed_limit.path_mm_s == 50.0);
  CHECK(std::isinf(p.speed_limit.point_mm_s[0]));
  CHECK(p.speed_limit.point_mm_s[1] == 50.0);
  CHECK(std::isinf(p.speed_limit.point_mm_s[2]));
  CHECK(p.place == "job: paths[0]");
  CHECK(paths[1].tool == "flange");
  CHECK(paths[1].speed_limit.point_mm_s.empty());
}

TEST_CASE("JSON: arcs and splines are given as such, with the speed of their end") {
  const auto paths = paths_of(read_paths_json, R"({"paths": [{"points": [[0,0], [4,0],
    {"to": [4,6,20], "centre": [4,3]}, {"clockwise": true, "centre": [4,0], "to": [10,0,null]},
    {"to": [13,3], "control": [10,1,11,3]}]}]})");
  REQUIRE(paths.size() == 1);
  const auto& p = paths[0].path.points;
  const auto& speed = paths[0].speed_limit.point_mm_s;
  REQUIRE(speed.size() == p.size());
  const auto at = [&](Point2 q) { return std::size_t(std::find(p.begin(), p.end(), q) - p.begin()); };
  const std::size_t top = at({4, 6}), right = at({10, 0}), last = at({13, 3});
  REQUIRE(last + 1 == p.size());
  for (std::size_t i = 1; i < p.size(); ++i) {
    CHECK(speed[i] == (i > 1 && i <= top ? 20.0 : motion::kUnlimited));
    if (i > top && i <= right) CHECK(distance(p[i], {4, 0}) == Approx(6.0).epsilon(1e-12));
  }
  for (std::size_t i = 2; i < top; ++i) {
    CHECK(distance(p[i], {4, 3}) == Approx(3.0).epsilon(1e-12));
    CHECK(p[i].x_mm > 4.0);  // anticlockwise
  }
  CHECK(p[(top + right) / 2].x_mm > 4.0);
  // the middle of the spline, whatever its points are: t = 1/2 at (10.75, 1.875)
  double least = 1.0;
  for (std::size_t i = right + 1; i < last; ++i) {
    const Point2 a = p[i], b = p[i + 1];
    const double length = distance(a, b), x = 10.75 - a.x_mm, y = 1.875 - a.y_mm;
    const double along = (x * (b.x_mm - a.x_mm) + y * (b.y_mm - a.y_mm)) / length;
    if (along >= 0.0 && along <= length)
      least = std::min(least, std::abs(x * (b.y_mm - a.y_mm) - y * (b.x_mm - a.x_mm)) / length);
  }
  CHECK(least < 2e-3);
}

TEST_CASE("JSON: a mistake in an arc or a spline is named with its place") {
  const auto of = [](const std::string& shape) {
    return json("{\"paths\": [{\"points\": [[0,0]," + shape + "]}]}");
  };
  CHECK(of("{\"to\": [4,0]}").find("paths[0].points[1]: must be {\"to\"") != std::string::npos);
  CHECK(of("{\"to\": [4,0], \"centre\": [1,0], \"control\": [1,1,2,2]}").find("must be") !=
        std::string::npos);
  CHECK(of("{\"to\": [4,0], \"centre\": [1,0]}").find("radius is 1 mm at its start and 3 mm at its end") !=
        std::string::npos);
  CHECK(of("{\"to\": [4,0], \"center\": [2,0]}").find("the nearest known one is centre") !=
        std::string::npos);
  CHECK(of("{\"to\": [4,0], \"control\": [2,0]}").find("control must be") != std::string::npos);
  CHECK(of("{\"to\": [4,0,-1], \"centre\": [2,0]}").find("-1 must lie in (0") != std::string::npos);
  CHECK(of("{\"to\": [4,0], \"centre\": [2,0], \"clockwise\": 1}").find("true or false") !=
        std::string::npos);
  CHECK(json("{\"paths\": [{\"points\": [{\"to\": [4,0], \"centre\": [2,0]}]}]}").find("not an object") !=
        std::string::npos);
}

TEST_CASE("JSON: every mistake names the key or byte, the limit and the nearest known word") {
  CHECK_THAT(json(""), Contains("job: byte"));
  CHECK_THAT(json("{\"paths\": [}"), Contains("job: byte 12"));
  CHECK_THAT(json("[]"), Contains("must be an object"));
  CHECK_THAT(json("{}"), Contains("has no key \"paths\""));
  CHECK_THAT(json("{\"paths\": []}"), Contains("holds no path"));
  CHECK_THAT(json("{\"version\": 2}"), Contains("version: 2 is unknown"));
  CHECK_THAT(json("{\"path\": []}"), Contains("path: unknown key; the nearest known one is paths"));
  const auto in_path = [](const std::string& body) {
    return json("{\"paths\": [{\"points\": [[0,0]]}, {" + body + "}]}");
  };
  CHECK_THAT(in_path("\"point\": [[1, 2]]"),
             Contains("paths[1]") && Contains("the nearest known one is points"));
  CHECK_THAT(in_path("\"closed\": 1"), Contains("paths[1].closed: must be true or false"));
  CHECK_THAT(in_path("\"kind\": \"fil\""),
             Contains("did you mean \"fill\"?") && Contains("one of boundary, fill"));
  CHECK_THAT(in_path("\"layer\": 1.5"), Contains("paths[1].layer: must be a whole number"));
  CHECK_THAT(in_path("\"layer\": -1"), Contains("paths[1].layer: -1 must lie in [0, "));
  CHECK_THAT(in_path("\"speed_mm_s\": 0"), Contains("paths[1].speed_mm_s: 0 must lie in (0, "));
  CHECK_THAT(in_path("\"points\": [[1, 2], [3]]"), Contains("paths[1].points[1]: must be [x_mm, y_mm]"));
  CHECK_THAT(in_path("\"points\": [[1, 2, 3, 4]]"),
             Contains("paths[1].points[0]") && Contains("more numbers"));
  CHECK_THAT(in_path("\"points\": [[1, \"a\"]]"), Contains("not a text"));
  CHECK_THAT(in_path("\"points\": [[1, 1e9]]"), Contains("must lie in [-100000"));
  CHECK_THAT(in_path("\"points\": [[[1]]]"), Contains("not a list"));
  CHECK_THAT(in_path("\"layer\": 1"), Contains("paths[1]: has no points"));
  CHECK_THAT(in_path("\"points\": [[1, 1e999]]"), Contains("job: byte"));
}

TEST_CASE("Any bytes are read or refused, never worse") {
  const std::string good_json =
      R"({"version":1,"paths":[{"points":[[0,0],[1,2,50]],"kind":"fill","closed":false,"layer":3}]})";
  const std::string good_csv = "x_mm,y_mm,speed_mm_s\n1,2,3\n4,5,\n\n6,7,8\n";
  RandomStream random(84, Purpose::kTest);
  const std::string alphabet = "[]{},:\"0123456789.-+eE\n \\ntrufalsx\xff";
  for (int trial = 0; trial < 20000; ++trial) {
    std::string text = trial % 2 ? good_json : good_csv;
    for (std::uint32_t n = 1 + random.below(5); n > 0; --n) {
      const std::size_t at = random.below(std::uint32_t(text.size()));
      const char c = alphabet[random.below(std::uint32_t(alphabet.size()))];
      if (random.below(3) == 0)
        text.erase(at, 1 + random.below(4));
      else if (random.below(2))
        text[at] = c;
      else
        text.insert(at, 1, c);
      if (text.empty()) text = "x";
    }
    try {
      for (const InputPath& p : paths_of(trial % 2 ? read_paths_json : read_paths_csv, text))
        for (const Point2& q : p.path.points) REQUIRE(std::isfinite(q.x_mm + q.y_mm));
    } catch (const UsageError&) {
    }
  }
}

TEST_CASE("A missing file or another ending is refused by name") {
  const auto nothing = [](InputPath&&) {};
  CHECK_THROWS_WITH(read_paths("no/such.csv", nothing), Contains("no such file"));
  CHECK_THROWS_WITH(read_paths(".", nothing), Contains("is a folder"));
  CHECK_THROWS_WITH(read_paths(FIRN_SOURCE_DIR "/README.md", nothing), Contains(".csv, .json or .paths"));
}
