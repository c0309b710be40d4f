// Pictures of plans against the motion's own formula: curves, deviation, activity and texts are read back.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "report/paths/path_maps.h"
#include "report/paths/plan_plot.h"
#include "tests/report/markup.h"

namespace firn::test {
namespace {

using motion::TraceSample;

constexpr double kMotionS = 4.0, kTickS = 0.002;
constexpr double kSwingRad = 40.0, kToolX = 3000.0, kToolY = -4000.0;  // times the polynomial below

// Derivative `order` of u^4 (1 - u)^4 over time, u = t / 4 s: at rest at both ends up to the jerk.
double polynomial(double t_s, int order) {
  constexpr std::array<double, 9> kCoefficients{0, 0, 0, 0, 1, -4, 6, -4, 1};
  double sum = 0.0;
  for (int n = order; n < 9; ++n) {
    double falling = 1.0;
    for (int k = 0; k < order; ++k) falling *= n - k;
    sum += kCoefficients[std::size_t(n)] * falling * std::pow(t_s / kMotionS, n - order);
  }
  return sum / std::pow(kMotionS, order);
}

report::PlanPlot polynomial_plan() {
  Trajectory t;
  t.tick_s = kTickS;
  t.axes = 2;
  report::PlanPlot p;
  std::vector<Point2> tool;
  for (int n = 0; n <= int(kMotionS / kTickS); ++n) {
    const double g = polynomial(n * kTickS, 0);
    t.positions.insert(t.positions.end(), {kSwingRad * g, -100.0 * g});
    tool.push_back({kToolX * g, kToolY * g});
  }
  p.title = "polynomial";
  p.trace = report::trace_of_samples(t, tool);
  p.limits = motion::cobra600_limits();
  p.joint_names = {"J1", "J2"};
  p.joint_units = {"rad", "mm"};
  return p;
}

const Element& chart_named(const Element& page, const std::string& title) {
  const Element* found = nullptr;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (!svg->children.empty() && svg->all("title").front()->text == title &&
        svg->all("svg", "role", "img").empty())
      found = svg;
  if (!found) throw std::runtime_error("no chart " + title);
  return *found;
}

std::vector<PixelPoint> curve_points(const Element& chart, const std::string& stroke) {
  std::vector<PixelPoint> all;
  for (const Element* path : chart.all("path", "stroke-linejoin", "round"))
    if (path->attribute("stroke") == stroke)
      for (const auto& piece : polylines_of(path->attribute("d")))
        all.insert(all.end(), piece.begin(), piece.end());
  return all;
}

// A trace along the x axis, a sample per 0.1 mm at 10 mm/s, half of each limit used.
report::PlanPlot straight_plan(int samples) {
  report::PlanPlot p;
  p.title = "straight";
  p.limits = motion::cobra600_limits();
  p.joint_names = {"J1"};
  p.joint_units = {"rad"};
  const auto half = [](const motion::RateLimits& l) {
    return std::array<double, 3>{0.5 * l.rate, 0.5 * l.acceleration, 0.5 * l.jerk};
  };
  for (int n = 0; n < samples; ++n) {
    TraceSample t;
    t.s_mm = 0.1 * n;
    t.t_s = 0.01 * n;
    t.at = {t.s_mm, 0.0};
    t.total = half(p.limits.position);
    t.joint[0] = half(p.limits.joint[0]);
    p.trace.push_back(t);
  }
  return p;
}

// Texts whose anchor lies outside the drawing that holds them.
void check_texts_inside(const Element& e, double width, double height, double left, double top) {
  if (e.name == "svg" && !e.attribute("viewBox").empty()) {
    REQUIRE(std::sscanf(e.attribute("viewBox").c_str(), "%lf %lf %lf %lf", &left, &top, &width, &height) ==
            4);
    left = -left;
    top = -top;
  }
  if (e.name == "g" && e.attribute("transform").starts_with("translate("))
    REQUIRE(std::sscanf(e.attribute("transform").c_str(), "translate(%lf %lf)", &left, &top) == 2);
  if (e.name == "text") {
    CAPTURE(e.text, width, height);
    CHECK(left + e.at("x") >= 0.0);
    CHECK(left + e.at("x") <= width);
    CHECK(top + e.at("y") >= 0.0);
    CHECK(top + e.at("y") <= height);
  }
  for (const Element& child : e.children) check_texts_inside(child, width, height, left, top);
}

TEST_CASE("Curves of speed, acceleration and jerk are the derivatives of the motion's formula") {
  const Element page = parse_markup(report::plan_picture(polynomial_plan()));
  struct Curve {
    const char* title;
    int order;
    double factor;
    bool norm;
  };
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const Curve& c :
       {Curve{"total speed", 1, 5000.0, true}, Curve{"total acceleration", 2, 5000.0, true},
        Curve{"total jerk", 3, 5000.0, true}, Curve{"J1 rate", 1, kSwingRad * kDegrees, false},
        Curve{"J1 acceleration", 2, kSwingRad * kDegrees, false},
        Curve{"J1 jerk", 3, kSwingRad * kDegrees, false}, Curve{"J2 rate", 1, -100.0, false},
        Curve{"J2 acceleration", 2, -100.0, false}, Curve{"J2 jerk", 3, -100.0, false}}) {
    CAPTURE(c.title);
    const Element& chart = chart_named(page, c.title);
    const ReadAxis t = x_axis_of(chart), y = y_axis_of(chart);
    const auto line = curve_points(chart, "var(--c0)");
    REQUIRE(line.size() > 300);
    // A backward difference of order k belongs k / 2 ticks earlier.
    for (const PixelPoint& at : line) {
      const double time = t.value(at.x);
      const double slope = std::abs(c.factor * polynomial(time, c.order + 1));
      const double exact = c.factor * polynomial(std::max(0.0, time - 0.5 * c.order * kTickS), c.order);
      const double pixel = 0.3 * std::abs(y.per_px(at.y)) + slope * (0.3 * t.per_px(at.x) + kTickS);
      CHECK(std::abs(y.value(at.y) - (c.norm ? std::abs(exact) : exact)) < pixel + 0.003 * std::abs(exact));
    }
    CHECK(t.value(line.back().x) == Approx(kMotionS).margin(0.01));
  }
}

TEST_CASE("Every chart of two plans has the same axis of time, and the shorter motion ends where it ends") {
  report::PlanPlot fast = polynomial_plan(), slow = fast;
  for (TraceSample& t : slow.trace) t.t_s *= 2.5;
  const Element page = parse_markup(report::plan_pictures_beside(fast, slow));
  for (const char* title : {"total speed", "total jerk", "J1 rate", "J2 acceleration"}) {
    CAPTURE(title);
    std::vector<double> begins, ends, lasts;
    for (const Element* svg : page.all("svg", "role", "img")) {
      if (svg->all("title").front()->text != title) continue;
      const ReadAxis t = x_axis_of(*svg);
      begins.push_back(t.value(54.0));
      ends.push_back(t.value(414.0));
      lasts.push_back(t.value(curve_points(*svg, "var(--c0)").back().x));
    }
    REQUIRE(ends.size() == 2);
    CHECK(begins[0] == Approx(begins[1]).margin(1e-9));
    CHECK(ends[0] == Approx(ends[1]));
    CHECK(lasts[0] == Approx(kMotionS).margin(0.02));
    CHECK(lasts[1] == Approx(2.5 * kMotionS).margin(0.02));
  }
}

TEST_CASE("The deviation's curve is the distance from the polygon in micrometres, its bound a line") {
  report::PlanPlot p = straight_plan(1001);
  p.points = {{0.0, 0.0}, {100.0, 0.0}};
  p.deviation_mm = 0.05;
  for (TraceSample& t : p.trace) t.at.y_mm = 0.04 * std::sin(0.1 * t.at.x_mm);
  const Element page = parse_markup(report::plan_picture(p));
  const Element& chart = chart_named(page, "deviation");
  const ReadAxis s = x_axis_of(chart), off = y_axis_of(chart);
  const auto line = curve_points(chart, "var(--c0)");
  REQUIRE(line.size() > 300);
  for (const PixelPoint& at : line)
    CHECK(off.value(at.y) == Approx(40.0 * std::abs(std::sin(0.1 * s.value(at.x)))).margin(1.0));
  const auto bound = curve_points(chart, "var(--fg)");
  REQUIRE(bound.size() == 2);
  CHECK(off.value(bound[0].y) == Approx(50.0).margin(0.3));
  CHECK(s.value(bound[1].x) - s.value(bound[0].x) == Approx(100.0).margin(0.3));
}

TEST_CASE("A plan without its points has neither a deviation's curve nor its map") {
  const Element page = parse_markup(report::plan_picture(straight_plan(50)));
  CHECK_THROWS(chart_named(page, "deviation"));
  CHECK_THROWS(chart_named(page, "path coloured by its deviation"));
  CHECK_NOTHROW(chart_named(page, "path coloured by speed"));
}

TEST_CASE("Each limit's strip is brightest where its ratio is 1, orange above, half as far at a half") {
  const report::PlanPlot half = straight_plan(1001);
  for (int row = 0; row < 6; ++row) {
    report::PlanPlot p = half;
    const int k = row % 3;
    // From 30 mm to 40 mm the limit is met exactly, from 60 mm to 70 mm it is exceeded; joints run backwards.
    for (TraceSample& t : p.trace) {
      double& value = row < 3 ? t.total[std::size_t(k)] : t.joint[0][std::size_t(k)];
      if (row >= 3) value = -value;
      if (t.s_mm > 30.0 && t.s_mm < 40.0) value *= 2.0;
      if (t.s_mm > 60.0 && t.s_mm < 70.0) value *= 2.1;
    }
    const Element page = parse_markup(report::plan_picture(p));
    const auto strips = chart_named(page, "activity of each limit along the path").all("image");
    REQUIRE(strips.size() == 6);
    for (int n = 0; n < 6; ++n) {
      const ReadPicture strip = picture_of(*strips[std::size_t(n)]);
      const auto at_mm = [&](double mm) { return strip.at(int(strip.width * mm / 100.0), 0); };
      const std::array<std::uint8_t, 4> middle{124, 123, 120, 255}, top{254, 232, 56, 255},
          above{213, 94, 0, 255};
      CAPTURE(row, n);
      CHECK(at_mm(35.0) == (n == row ? top : middle));
      CHECK(at_mm(65.0) == (n == row ? above : middle));
      CHECK(at_mm(10.0) == middle);
      CHECK(at_mm(99.0) == middle);
    }
  }
}

TEST_CASE("A quantity without a limit has no strip and no line of a limit") {
  report::PlanPlot p = straight_plan(200);
  p.limits.joint[0].jerk = std::numeric_limits<double>::infinity();
  const Element page = parse_markup(report::plan_picture(p));
  CHECK(chart_named(page, "activity of each limit along the path").all("image").size() == 5);
  CHECK(curve_points(chart_named(page, "J1 jerk"), "var(--fg)").empty());
  CHECK(curve_points(chart_named(page, "J1 rate"), "var(--fg)").size() == 4);
}

TEST_CASE("Every text of a plan's picture lies inside its drawing") {
  report::PlanPlot p = polynomial_plan();
  p.points = {{0.0, 0.0}, {12.0, -16.0}};
  p.deviation_mm = 0.02;
  for (int n = 0; n < 9; ++n) p.certificate.limits.push_back({"limit " + std::to_string(n), 0.5, 1.0});
  p.certificate.duration_s = kMotionS;
  p.certificate.lower_bound_s = 3.0;
  const Element alone = parse_markup(report::plan_picture(p));
  CHECK(alone.all("text").size() > 100);
  check_texts_inside(alone, 0.0, 0.0, 0.0, 0.0);
  check_texts_inside(parse_markup(report::plan_pictures_beside(p, straight_plan(20))), 0.0, 0.0, 0.0, 0.0);
}

TEST_CASE("Names with markup, quotes and foreign letters come back as they were given") {
  report::PlanPlot p = straight_plan(20);
  const std::string title = "<b>\"Düse\" & Öl</b> 液滴", joint = "轴 <1> & \"zwei\"";
  p.title = title;
  p.joint_names = {joint};
  p.certificate.limits = {{"</svg>" + joint, 0.5, 0.1}};
  const Element page = parse_markup(report::plan_pictures_beside(p, p));
  CHECK(page.children.at(0).all("title").front()->text == title + " | " + title);
  CHECK(page.all("text", "class", "head").at(0)->text == title);
  CHECK_NOTHROW(chart_named(page, joint + " rate"));
  int rows = 0;
  for (const Element* text : page.all("text")) rows += text->text == "</svg>" + joint;
  CHECK(rows == 2);
}

TEST_CASE("Maps and strips of no sample and of one sample are drawn, without a line") {
  for (const int samples : {0, 1}) {
    const report::PlanPlot p = straight_plan(samples);
    const Element map = parse_markup(report::speed_map(p.trace, 125.0, "few"));
    CHECK(map.all("g", "stroke-width", "4").at(0)->children.empty());
    CHECK(report::along_path(p.trace).size() == std::size_t(samples));
    const Element strips = parse_markup(report::limit_strips(report::along_path(p.trace), {}, 864.0, "few"));
    CHECK(strips.all("image").empty());
    CHECK(report::deviations(p.trace, {{0.0, 3.0}, {10.0, 3.0}}) ==
          std::vector<double>(std::size_t(samples), 3.0));
  }
  const Element picture = parse_markup(report::plan_picture(straight_plan(1)));
  CHECK(picture.all("image").size() == 6);
}

}  // namespace
}  // namespace firn::test
