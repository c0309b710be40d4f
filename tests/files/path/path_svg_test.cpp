// Paths from SVG: path data, shapes, transforms and units against closed forms; anything else is named.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "core/grid/random.h"
#include "files/path/path_file.h"
#include "files/usage_error.h"
#include "tests/files/path/path_reader.h"

namespace firn {
namespace {

constexpr test::PathReader<read_paths_svg> svg_paths{"part.svg"};

/// A page of 100 x 50 mm whose unit is a millimetre.
std::vector<InputPath> on_page(const std::string& content) {
  return svg_paths(
      "<svg xmlns='http://www.w3.org/2000/svg' width='100mm' height='50mm' viewBox='0 0 100 50'>" + content +
      "</svg>");
}

std::string svg_refusal(const std::string& text) { return svg_paths.refusal(text); }

double off(Point2 a, Point2 b) { return distance(a, b); }

}  // namespace

TEST_CASE("Lines of path data, absolute and relative, with y upwards from the page's lower edge") {
  for (const char* d : {"M10 20 L30 20 V40 H10 Z", "m10,20h20v20h-20z", "M10 20 30 20 30 40 10 40z",
                        "M 10,20 l+2e1,0 0,20-20-0Z"}) {
    INFO(d);
    const auto paths = on_page(std::string("\n<path d='") + d + "'/>");
    REQUIRE(paths.size() == 1);
    CHECK(paths[0].place == "part.svg:2");
    const std::vector<Point2> expected{{10, 30}, {30, 30}, {30, 10}, {10, 10}, {10, 30}};
    REQUIRE(paths[0].path.points.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      CHECK(off(paths[0].path.points[i], expected[i]) < 1e-12);
  }
}

TEST_CASE("Each subpath is a path of its own, and after Z the next begins where the last did") {
  const auto paths = on_page("<path d='M0 0 1 0 1 1z l5 0 M9 9'/><line x1='1' y1='1' x2='2' y2='1'/>");
  REQUIRE(paths.size() == 3);
  CHECK(paths[1].path.points.front() == Point2{0, 50});
  CHECK(paths[1].path.points.back() == Point2{5, 50});
  CHECK(paths[2].number == 3);
}

TEST_CASE("Every point of an elliptic arc lies on its ellipse, and the flags choose among the four arcs") {
  RandomStream draw(3, Purpose::kTest);
  for (int trial = 0; trial < 200; ++trial) {
    const double rx = draw.uniform(1.0, 20.0), ry = draw.uniform(1.0, 20.0),
                 turn = draw.uniform(-180.0, 180.0);
    const double start = draw.uniform(-3.1, 3.1), sweep = draw.uniform(-6.2, 6.2);
    const Point2 centre{draw.uniform(0.0, 50.0), draw.uniform(0.0, 50.0)};
    const double c = std::cos(turn * std::numbers::pi / 180.0), s = std::sin(turn * std::numbers::pi / 180.0);
    const auto at = [&](double angle) {
      const double u = rx * std::cos(angle), v = ry * std::sin(angle);
      return Point2{centre.x_mm + c * u - s * v, centre.y_mm + s * u + c * v};
    };
    const Point2 from = at(start), to = at(start + sweep);
    std::ostringstream d;
    d.precision(17);
    d << "<path d='M" << from.x_mm << ' ' << from.y_mm << 'A' << rx << ' ' << ry << ' ' << turn << ' '
      << (std::abs(sweep) > std::numbers::pi) << (sweep > 0.0) << to.x_mm << ',' << to.y_mm << "'/>";
    INFO(d.str());
    const auto paths = on_page(d.str());
    REQUIRE(paths.size() == 1);
    double length = 0.0, exact = 0.0;
    const auto& p = paths[0].path.points;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const double x = p[i].x_mm - centre.x_mm, y = 50.0 - p[i].y_mm - centre.y_mm;
      const double u = (c * x + s * y) / rx, v = (-s * x + c * y) / ry;
      CHECK(std::abs(std::sqrt(u * u + v * v) - 1.0) < 1e-6);
      if (i > 0) length += distance(p[i - 1], p[i]);
    }
    for (int i = 0; i < 4000; ++i)
      exact += distance(at(start + sweep * i / 4000), at(start + sweep * (i + 1) / 4000));
    CHECK(std::abs(length - exact) < 1e-3 * exact + 1e-6);  // the other arcs are longer or shorter
  }
}

TEST_CASE("Quadratic and smooth curves are the cubics that they stand for") {
  const auto ends = [](const std::string& d) {
    const auto paths = on_page("<path d='" + d + "'/>");
    return paths.at(0).path.points;
  };
  const auto same = [&](const std::string& a, const std::string& b) {
    const auto p = ends(a), q = ends(b);
    REQUIRE(p.size() == q.size());
    for (std::size_t i = 0; i < p.size(); ++i) CHECK(off(p[i], q[i]) < 1e-9);
  };
  same("M0 0 Q6 9 12 0", "M0 0 C4 6 8 6 12 0");
  same("M0 0 Q6 9 12 0 T24 0", "M0 0 Q6 9 12 0 Q18 -9 24 0");
  same("M0 0 C1 5 5 5 6 0 S11 -5 12 0", "M0 0 C1 5 5 5 6 0 C7 -5 11 -5 12 0");
  same("M0 0 c1 5 5 5 6 0 s5 -5 6 0", "M0 0 C1 5 5 5 6 0 C7 -5 11 -5 12 0");
  same("M0 0 S5 5 6 0", "M0 0 C0 0 5 5 6 0");
}

TEST_CASE("Transforms are applied from the inside out, in every notation") {
  const auto at = [](const std::string& transform) {
    const auto paths =
        on_page("<g transform='" + transform + "'><path transform='scale(2)' d='M1 0 L5 0'/></g>");
    return paths.at(0).path.points.front();
  };
  CHECK(off(at("translate(3,4)"), {5, 46}) < 1e-12);
  CHECK(off(at("translate(3)"), {5, 50}) < 1e-12);
  CHECK(off(at("rotate(90)"), {0, 48}) < 1e-12);
  CHECK(off(at("rotate(90 1 1)"), {2, 48}) < 1e-12);
  CHECK(off(at("matrix(1 2 3 4 5 6)"), {7, 40}) < 1e-12);
  CHECK(off(at("scale(3 7) translate(1,1)"), {9, 43}) < 1e-12);
  CHECK(off(at("skewX(45)translate(0 1)"), {3, 49}) < 1e-12);
  CHECK(off(at("skewY(45)"), {2, 48}) < 1e-12);
}

TEST_CASE("Sizes in units: the viewBox is fitted into the page, without one a unit is 1/96 inch") {
  const auto width = [](const std::string& head) {
    const auto p = svg_paths("<svg " + head + "><path d='M0 0h96'/></svg>").at(0).path.points;
    return distance(p.front(), p.back());
  };
  CHECK(width("") == Approx(25.4));
  CHECK(width("width='10cm' viewBox='0 0 96 10'") == Approx(100.0));
  CHECK(width("width='2in' height='1in' viewBox='0 0 192 960'") == Approx(96 * 25.4 / 960));
  CHECK(width("width='100%' height='100%'") == Approx(25.4));
  CHECK(width("width='72pt' viewBox='0 0 96 96'") == Approx(25.4));
}

TEST_CASE("A viewBox of another shape than its page is centred in it, or as preserveAspectRatio says") {
  const auto line = [](const std::string& how) {  // across the box, along its lower edge
    return svg_paths("<svg width='100mm' height='50mm' viewBox='0 0 50 50' " + how +
                     "><path d='M0 50 h50'/></svg>")
        .at(0)
        .path.points;
  };
  const auto lies = [&](const std::string& how, Point2 from, Point2 to) {
    const std::vector<Point2> p = line(how);
    INFO(how);
    CHECK(distance(p.front(), from) < 1e-12);
    CHECK(distance(p.back(), to) < 1e-12);
  };
  lies("", {25, 0}, {75, 0});
  lies("preserveAspectRatio='xMinYMid'", {0, 0}, {50, 0});
  lies("preserveAspectRatio='xMaxYMin meet'", {50, 0}, {100, 0});
  lies("preserveAspectRatio='xMidYMin slice'", {0, -50}, {100, -50});
  lies("preserveAspectRatio='xMidYMax slice'", {0, 0}, {100, 0});
  lies("preserveAspectRatio='none'", {0, 0}, {100, 0});
}

TEST_CASE("Circles and ellipses are closed, and what is defined but not drawn is left out") {
  const auto paths = on_page(
      "<defs><path d='M0 0 9 9'/></defs><circle cx='10' cy='10' r='5'/>"
      "<g display='none'><path d='M0 0 9 9'/></g><ellipse rx='4' ry='2'/>");
  REQUIRE(paths.size() == 2);
  for (const InputPath& p : paths) CHECK(off(p.path.points.front(), p.path.points.back()) < 1e-12);
  for (const Point2& p : paths[0].path.points) CHECK(std::abs(distance(p, {10, 40}) - 5.0) < 1e-7);
}

TEST_CASE("What is wrong in an SVG is said with file, line and limit") {
  const auto names = [](const std::string& text, const std::string& part) {
    const std::string said = svg_refusal(text);
    INFO(said);
    CHECK(said.find("part.svg:") == 0);
    CHECK(said.find(part) != std::string::npos);
  };
  names("<svg>\n<path d='M0 0 L1'/></svg>", "part.svg:2: character 8: a finite number is needed");
  names("<svg><path d='L1 1'/></svg>", "must begin with M");
  names("<svg><path d='M1 1 X2'/></svg>", "M, L, H, V, C, S, Q, T, A or Z");
  names("<svg><path d='M1 1 A1 1 0 2 0 3 3'/></svg>", "a flag, 0 or 1");
  names("<svg><path d='M0 0 L1e9 0'/></svg>", "beyond the limit of +-100000");
  names("<svg><path d='M0 0 L1e999 0'/></svg>", "a finite number");
  names("<svg><use href='#a'/></svg>", "<use> of \"#a\", which the file does not hold");
  names("<svg><text>a</text></svg>", "<text> is not read");
  names("<svg><path transform='turn(3)' d='M0 0'/></svg>", "'turn' is not read");
  names("<svg width='3 miles'/>", "mm, cm, in, pt, pc, px or %");
  names("<svg viewBox='0 0 0 1'/>", "viewBox");
  names("<svg><path d='M0 0 1 1'></svg>", "is not XML");
  names("<svg>\n<g clip-path='url(#a)'><path d='M0 0 1 1'/></g></svg>", "part.svg:2: clip-path = url(#a)");
  names("<svg><path style='mask:url(#m)' d='M0 0 1 1'/></svg>", "mask = url(#m)");
  names("<svg width='1' height='2' viewBox='0 0 1 1' preserveAspectRatio='xMid'/>", "preserveAspectRatio");
  names("<html/>", "the first element must be svg");
  names("<svg/>", "holds no path");
  std::string deep = "<svg>";
  for (int i = 0; i < 300; ++i) deep += "<g>";
  names(deep, "nested deeper than 200");
}

TEST_CASE("A rectangle's corners are arcs, one radius stands for both, and none is larger than half a side") {
  const auto paths = on_page(
      "<rect x='10' y='10' width='20' height='10' rx='3'/><rect width='8' height='4' rx='9' ry='1'/>"
      "<rect width='8' height='4' rx='0'/><rect width='0' height='4'/>");
  REQUIRE(paths.size() == 3);
  CHECK(paths[0].given.size() == 4);
  double farthest = 0.0;
  for (const Point2& p : paths[0].path.points) farthest = std::max(farthest, off(p, {20, 35}));
  CHECK(farthest == Approx(std::hypot(7.0, 2.0) + 3.0).epsilon(1e-4));
  CHECK(paths[1].path.points.front() == paths[1].path.points.back());
  CHECK(paths[2].path.points.size() == 5);
}

TEST_CASE("A style hides shapes as attributes do") {
  const auto paths = on_page(
      "<g style='fill:none; display : none'><path d='M0 0 9 9'/><text/></g>"
      "<g visibility='hidden'><path d='M0 0 8 8'/><path d='M0 0 7 7' style='visibility:visible'/></g>");
  REQUIRE(paths.size() == 1);
  CHECK(off(paths[0].path.points.back(), {7, 43}) < 1e-12);
}

}  // namespace firn
