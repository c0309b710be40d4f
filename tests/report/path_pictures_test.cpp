// Pictures of planned paths and of sliced layers: positions, times and limits read back from the drawings.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <sstream>

#include "core/grid/random.h"
#include "core/motion/aerosol/paper_jobs.h"
#include "core/motion/aerosol/plan.h"
#include "files/path/path_file.h"
#include "report/paths/aerosol_pictures.h"
#include "report/paths/path_maps.h"
#include "report/paths/plan_plot.h"
#include "report/paths/slice_pictures.h"
#include "tests/report/markup.h"

namespace firn::test {
namespace {

using motion::AerosolMachine;
using motion::AerosolPlan;
using motion::TraceSample;

struct Planned {
  PrintJob job = motion::thompson_fig7();
  AerosolMachine machine;
  AerosolPlan plan = motion::plan_aerosol(job, machine);
};

// The drawn line of a colour, joined where it is in pieces.
std::vector<PixelPoint> line_of(const Element& chart, const std::string& stroke) {
  std::vector<PixelPoint> all;
  for (const Element* path : chart.all("path", "stroke-linejoin", "round"))
    if (path->attribute("stroke") == stroke)
      for (const auto& piece : polylines_of(path->attribute("d")))
        all.insert(all.end(), piece.begin(), piece.end());
  return all;
}

// A circle of radius 20 mm about (100, 50), run through once at a constant 40 mm/s.
std::vector<TraceSample> circle_trace(int samples) {
  std::vector<TraceSample> trace;
  constexpr double kRadius = 20.0, kSpeed = 40.0;
  for (int n = 0; n < samples; ++n) {
    TraceSample t;
    t.s_mm = 2.0 * std::numbers::pi * kRadius * n / (samples - 1);
    t.t_s = t.s_mm / kSpeed;
    const double a = t.s_mm / kRadius;
    t.at = {100.0 + kRadius * std::cos(a), 50.0 + kRadius * std::sin(a)};
    t.total = {kSpeed, kSpeed * kSpeed / kRadius, 0.0};
    t.joint[0] = {0.5 * std::sin(a), 0.2 * std::cos(a), 0.1};
    trace.push_back(t);
  }
  return trace;
}

geometry::Rings square(double x_mm, double y_mm, double side_mm) {
  const auto unit = [](double mm) { return std::int32_t(std::lround(mm * geometry::kUnitsPerMm)); };
  geometry::Rings r;
  const std::vector<geometry::Point> ring{{unit(x_mm), unit(y_mm)},
                                          {unit(x_mm + side_mm), unit(y_mm)},
                                          {unit(x_mm + side_mm), unit(y_mm + side_mm)},
                                          {unit(x_mm), unit(y_mm + side_mm)}};
  r.add(ring);
  return r;
}

// A square of part and a square of scaffold beside it, a boundary, a fill and a measurement line.
report::PicturedLayer layer(int number) {
  report::PicturedLayer l;
  l.regions.layer = l.paths.layer = number;
  l.regions.z = l.paths.z = 2400 * number;
  l.paths.height = 2400;
  l.regions.by_material = {square(-10, -5, 10), square(0, -5, 10)};
  const auto add = [&](const geometry::Rings& line, slice::PathInfo info) {
    l.paths.lines.add(line[0]);
    l.paths.info.push_back(info);
  };
  add(square(-9.5, -4.5, 9), {PathKind::kBoundary, 0, true, 6000});
  add(square(-8, -3, 6), {PathKind::kFill, 0, false, 6000});
  add(square(1, -4, 8), {PathKind::kFill, 1, false, 5000});
  add(square(-9, -4, 18), {PathKind::kMeasurement, 0, false, 0});
  return l;
}

double area(const std::vector<PixelPoint>& ring) {
  double twice = 0.0;
  for (std::size_t n = 0; n < ring.size(); ++n) {
    const PixelPoint &a = ring[n], &b = ring[(n + 1) % ring.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return 0.5 * std::abs(twice);
}

struct Box {
  double left = 1e300, right = -1e300, top = 1e300, bottom = -1e300;
  void take(double x, double y) {
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
  bool meets(const Box& o) const {
    return left < o.right && o.left < right && top < o.bottom && o.top < bottom;
  }
};

TEST_CASE("The speed picture of a shuttered printer shows both axes' speeds at their times") {
  const Planned p;
  REQUIRE(p.plan.ok());
  const Element page = parse_markup(report::aerosol_speed_picture(p.plan, "speeds"));
  const ReadAxis t = x_axis_of(page), v = y_axis_of(page);
  for (const auto& [stroke, axis] : {std::pair{"var(--c0)", 0}, {"var(--c1)", 1}}) {
    const auto line = line_of(page, stroke);
    REQUIRE(line.size() > 100);
    // Between two drawn points a ramp is straight: compare in the middle of the gap, off the corners.
    double worst = 0.0;
    for (std::size_t n = 0; n < line.size(); n += 5) {
      const double at = t.value(line[n].x);
      double nearest = 1e9;
      for (const double dt : {-0.006, -0.003, 0.0, 0.003, 0.006}) {
        const auto s = motion::state_at(p.plan, std::clamp(at + dt, 0.0, p.plan.duration_s()));
        nearest = std::min(nearest, std::abs(v.value(line[n].y) - (axis ? s.v_mm_s.y_mm : s.v_mm_s.x_mm)));
      }
      worst = std::max(worst, nearest);
    }
    CHECK(worst < 0.25);
  }
}

TEST_CASE("The drawn position is the integral of the plan: it begins at the start and stops at the end") {
  const Planned p;
  const Element page = parse_markup(report::aerosol_position_picture(p.plan, "positions"));
  const ReadAxis t = x_axis_of(page), x = y_axis_of(page);
  const auto along_x = line_of(page, "var(--c0)"), along_y = line_of(page, "var(--c1)");
  REQUIRE(!along_x.empty());
  CHECK(x.value(along_x.front().y) == Approx(p.job.start.x_mm).margin(0.05));
  CHECK(x.value(along_y.front().y) == Approx(p.job.start.y_mm).margin(0.05));
  CHECK(x.value(along_x.back().y) == Approx(p.job.end.x_mm).margin(0.05));
  CHECK(x.value(along_y.back().y) == Approx(p.job.end.y_mm).margin(0.05));
  CHECK(t.value(along_x.back().x) == Approx(p.plan.duration_s()).margin(0.05));
}

TEST_CASE("Grey spans of a time chart are the times between the shutter's openings") {
  for (const PrintJob& job : {motion::thompson_fig7(), motion::thompson_fig11()}) {
    const AerosolPlan plan = motion::plan_aerosol(job, {});
    const Element page = parse_markup(report::aerosol_speed_picture(plan, "speeds"));
    const ReadAxis t = x_axis_of(page);
    double closed = 0.0, open = 0.0;
    const auto rects = page.all("rect", "fill-opacity", "0.18");
    for (std::size_t n = 0; n + 1 < rects.size(); ++n)  // the last is the legend's
      closed += std::abs(t.value(rects[n]->at("x") + rects[n]->at("width")) - t.value(rects[n]->at("x")));
    for (const ShutterSpan& s : plan.open) open += s.close_s - s.open_s;
    CHECK(closed + open == Approx(plan.duration_s()).margin(0.05));
    CHECK(open == Approx(plan.report.print_s));
  }
}

TEST_CASE("Errors are drawn while the shutter is open only, and never above the report's largest") {
  const Planned p;
  for (const bool speed : {true, false}) {
    const std::string svg = speed ? report::aerosol_speed_error_picture(p.job, p.plan, "e")
                                  : report::aerosol_path_error_picture(p.job, p.plan, "e");
    const Element page = parse_markup(svg);
    const ReadAxis t = x_axis_of(page), e = y_axis_of(page);
    const double most =
        speed ? 100.0 * p.plan.report.speed_error.value : 1e3 * p.plan.report.position_error_mm.value;
    for (const PixelPoint& at : line_of(page, "var(--c0)")) {
      bool open = false;
      for (const ShutterSpan& s : p.plan.open)
        open = open || (t.value(at.x) > s.open_s - 0.02 && t.value(at.x) < s.close_s + 0.02);
      CHECK(open);
      CHECK(e.value(at.y) <= most + 0.02 * std::max(1.0, most));
      CHECK(e.value(at.y) >= -0.02 * std::max(1.0, most));
    }
  }
}

TEST_CASE("Accelerations stay between the two lines of the limit") {
  const Planned p;
  const Element page = parse_markup(report::aerosol_acceleration_picture(p.plan, p.machine, "a"));
  const ReadAxis a = y_axis_of(page);
  const auto limit = line_of(page, "var(--fg)");
  REQUIRE(limit.size() == 4);
  for (const PixelPoint& at : limit)
    CHECK(std::abs(a.value(at.y)) == Approx(p.machine.axis.alpha_mm_s2).margin(0.2));
  double largest = 0.0;
  for (const char* stroke : {"var(--c0)", "var(--c1)"})
    for (const PixelPoint& at : line_of(page, stroke)) largest = std::max(largest, std::abs(a.value(at.y)));
  CHECK(largest <= p.machine.axis.alpha_mm_s2 + 0.3);
  CHECK(largest > 0.9 * p.machine.axis.alpha_mm_s2);
}

TEST_CASE("The path picture keeps the proportions of the substrate and draws each segment where it lies") {
  const Planned p;
  const Element page = parse_markup(report::aerosol_path_picture(p.job, p.plan, "path"));
  const ReadAxis x = x_axis_of(page), y = y_axis_of(page);
  CHECK(x.per_px(200.0) == Approx(y.per_px(200.0)).epsilon(0.01));
  const auto segments = page.all("path", "stroke-width", "7");
  REQUIRE(segments.size() == p.job.segments.size());
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const auto line = polylines_of(segments[n]->attribute("d")).at(0);
    CHECK(x.value(line[0].x) == Approx(p.job.segments[n].from.x_mm).margin(0.05));
    CHECK(y.value(line[0].y) == Approx(p.job.segments[n].from.y_mm).margin(0.05));
    CHECK(x.value(line[1].x) == Approx(p.job.segments[n].to.x_mm).margin(0.05));
    CHECK(y.value(line[1].y) == Approx(p.job.segments[n].to.y_mm).margin(0.05));
  }
}

TEST_CASE("The sheet of a shuttered plan holds its six charts side by side, none over another") {
  const Planned p;
  const Element page = parse_markup(report::aerosol_plot(p.job, p.plan, p.machine, "a <plan>"));
  const Element& sheet = page.children.at(0);
  std::vector<Box> boxes;
  for (const Element& chart : sheet.children) {
    if (chart.name != "svg") continue;
    Box b;
    b.take(chart.at("x"), chart.at("y"));
    b.take(chart.at("x") + chart.at("width"), chart.at("y") + chart.at("height"));
    for (const Box& o : boxes) CHECK_FALSE(b.meets(o));
    boxes.push_back(b);
  }
  CHECK(boxes.size() == 6);
  CHECK(sheet.only("style").text.find("--c0") != std::string::npos);
}

TEST_CASE("A speed map draws a circle as a circle, in one colour for one speed") {
  const Element page = parse_markup(report::speed_map(circle_trace(400), 80.0, "map"));
  std::map<std::string, int> colours;
  Box box;
  for (const Element* path : page.all("g", "stroke-width", "4").at(0)->all("path")) {
    ++colours[path->attribute("stroke")];
    for (const auto& line : polylines_of(path->attribute("d")))
      for (const PixelPoint& at : line) box.take(at.x, at.y);
  }
  CHECK(colours.size() == 1);
  CHECK(box.right - box.left == Approx(box.bottom - box.top).margin(0.3));
  CHECK(box.right - box.left > 150.0);
}

TEST_CASE("A faster stretch of a speed map is lighter") {
  std::vector<TraceSample> trace = circle_trace(200);
  for (std::size_t n = 0; n < trace.size(); ++n) trace[n].total[0] = 80.0 * double(n) / 200.0;
  const Element page = parse_markup(report::speed_map(trace, 80.0, "map"));
  double before = -1.0;
  for (const Element* path : page.all("g", "stroke-width", "4").at(0)->all("path")) {
    unsigned r = 0, g = 0, b = 0;
    REQUIRE(std::sscanf(path->attribute("stroke").c_str(), "#%02x%02x%02x", &r, &g, &b) == 3);
    const double lightness = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    CHECK(lightness >= before - 1.0);
    before = lightness;
  }
  CHECK(before > 200.0);
}

TEST_CASE(
    "Deviations are distances from the polygon near the same place, also where the path crosses itself") {
  std::vector<Point2> polygon;  // a circle of 20 mm, run through twice
  for (int n = 0; n <= 720; ++n) {
    const double a = n * std::numbers::pi / 180.0;
    polygon.push_back({100.0 + 20.0 * std::cos(a), 50.0 + 20.0 * std::sin(a)});
  }
  std::vector<TraceSample> trace;
  for (int n = 0; n <= 2000; ++n) {
    const double a = 4.0 * std::numbers::pi * n / 2000.0, r = 20.0 + 0.05 * std::sin(7.0 * a);
    TraceSample t;
    t.at = {100.0 + r * std::cos(a), 50.0 + r * std::sin(a)};
    trace.push_back(t);
  }
  const auto off = report::deviations(trace, polygon);
  REQUIRE(off.size() == trace.size());
  for (std::size_t n = 0; n < off.size(); ++n)  // 0.8 um: the chords' sagitta
    CHECK(off[n] ==
          Approx(0.05 * std::abs(std::sin(28.0 * std::numbers::pi * double(n) / 2000.0))).margin(1e-3));
}

TEST_CASE("A strip per limit is as long as the path and orange where the limit is exceeded") {
  std::vector<double> along;
  std::vector<report::LimitActivity> limits{{"speed", {}}, {"jerk", {}}};
  for (int n = 0; n <= 1000; ++n) {
    along.push_back(0.1 * n);
    limits[0].share.push_back(n / 1000.0);
    limits[1].share.push_back(n > 500 ? 1.2 : 0.0);
  }
  const Element page = parse_markup(report::limit_strips(along, limits, 864.0, "activity"));
  const auto strips = page.all("image");
  REQUIRE(strips.size() == 2);
  CHECK(strips[0]->at("width") == strips[1]->at("width"));
  CHECK(strips[0]->attribute("href") != strips[1]->attribute("href"));
  const auto texts = page.all("text");
  const auto has = [&](const std::string& text) {
    return std::any_of(texts.begin(), texts.end(), [&](const Element* e) { return e->text == text; });
  };
  CHECK(has("speed"));
  CHECK(has("jerk"));
  CHECK(has("100"));  // mm, the end of the axis
}

TEST_CASE("Two plans beside each other share their axis of time and do not overlap") {
  report::PlanPlot left;
  left.title = "left";
  left.trace = circle_trace(300);
  left.limits = motion::cobra600_limits();
  left.joint_names = {"J1"};
  left.joint_units = {"rad"};
  for (const TraceSample& t : left.trace) left.points.push_back(t.at);
  report::PlanPlot right = left;
  right.title = "right";
  for (TraceSample& t : right.trace) t.t_s *= 2.0;
  const Element page = parse_markup(report::plan_pictures_beside(left, right));
  std::vector<Box> boxes;
  const Element& sheet = page.children.at(0);
  for (const Element& chart : sheet.children) {
    if (chart.name != "svg") continue;
    Box b;
    b.take(chart.at("x"), chart.at("y"));
    b.take(chart.at("x") + chart.at("width"), chart.at("y") + chart.at("height"));
    for (const Box& o : boxes) CHECK_FALSE(b.meets(o));
    boxes.push_back(b);
  }
  REQUIRE(boxes.size() == 20);  // two maps, strips, deviation, and three charts for the total and for J1
  std::vector<double> ends;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->all("title").front()->text == "total speed") ends.push_back(x_axis_of(*svg).value(414.0));
  REQUIRE(ends.size() == 2);
  CHECK(ends[0] == Approx(ends[1]));
  CHECK(ends[0] >= right.trace.back().t_s - 0.02);
}

TEST_CASE("Two paths in one speed map are not joined") {
  std::vector<TraceSample> trace = circle_trace(100);
  const std::vector<TraceSample> second = circle_trace(100);
  for (TraceSample t : second) {
    t.at.x_mm += 60.0;
    trace.push_back(t);
  }
  const Element page = parse_markup(report::speed_map(trace, 80.0, "map"));
  for (const Element* path : page.all("g", "stroke-width", "4").at(0)->all("path")) {
    const auto line = polylines_of(path->attribute("d")).at(0);
    CHECK(std::hypot(line[1].x - line[0].x, line[1].y - line[0].y) < 10.0);
  }
}

TEST_CASE("Differences of a trajectory's samples are its derivatives: exact for a cubic after three ticks") {
  Trajectory t;
  t.tick_s = 0.01;
  t.axes = 1;
  std::vector<Point2> tool;
  for (int n = 0; n < 50; ++n) {
    const double s = n * t.tick_s;
    t.positions.push_back(2.0 * s * s * s - 3.0 * s);
    tool.push_back({4.0 * s * s * s, 3.0 * s * s * s});
  }
  const auto trace = report::trace_of_samples(t, tool);
  REQUIRE(trace.size() == 50);
  for (std::size_t n = 3; n < 50; ++n) {
    CHECK(trace[n].joint[0][2] == Approx(12.0).epsilon(1e-6));
    CHECK(trace[n].total[2] == Approx(30.0).epsilon(1e-6));  // (24, 18)
    const double s = (double(n) - 1.0) * t.tick_s;           // a second difference belongs a tick earlier
    CHECK(trace[n].joint[0][1] == Approx(12.0 * s).epsilon(1e-6));
    CHECK(trace[n].at.x_mm == tool[n].x_mm);
  }
  CHECK(trace[0].total == std::array<double, 3>{0.0, 0.0, 0.0});
}

TEST_CASE(
    "A plan's picture has a chart for every quantity, its limit where the axis says, joints in degrees") {
  report::PlanPlot plot;
  plot.title = "a & b";
  plot.trace = circle_trace(300);
  plot.limits = motion::cobra600_limits();
  plot.joint_names = {"J1", "J2"};
  plot.joint_units = {"rad", "rad"};
  plot.certificate.limits = {{"total speed", 0.32, 1.5}, {"J1 <rate>", 0.75, 0.25}};
  plot.certificate.duration_s = 3.1416;
  const Element page = parse_markup(report::plan_picture(plot));
  std::map<std::string, const Element*> charts;
  for (const Element* svg : page.all("svg", "role", "img"))
    charts[svg->name == "svg" && !svg->all("title").empty() ? svg->all("title").front()->text : ""] = svg;
  CHECK(page.all_text().find("J1 <rate>") != std::string::npos);
  CHECK(page.all_text().find("0.7500") != std::string::npos);
  for (const char* name : {"total speed", "total acceleration", "total jerk", "J1 rate", "J1 acceleration",
                           "J1 jerk", "J2 rate", "J2 acceleration", "J2 jerk"}) {
    CAPTURE(name);
    REQUIRE(charts.contains(name));
  }
  const Element& rate = *charts["J1 rate"];
  const ReadAxis y = y_axis_of(rate), t = x_axis_of(rate);
  for (const PixelPoint& at : line_of(rate, "var(--fg)"))
    CHECK(std::abs(y.value(at.y)) == Approx(33.0).margin(0.3));
  for (const PixelPoint& at : line_of(rate, "var(--c0)")) {
    const double a = t.value(at.x) * 40.0 / 20.0;
    CHECK(y.value(at.y) == Approx(0.5 * std::sin(a) * 180.0 / std::numbers::pi).margin(0.6));
  }
}

TEST_CASE("A chart of a long trace keeps the peak of a single sample") {
  report::PlanPlot plot;
  plot.title = "peak";
  plot.trace = circle_trace(20000);
  plot.limits = motion::cobra600_limits();
  plot.trace[7777].total[1] = 450.0;
  const Element page = parse_markup(report::plan_picture(plot));
  for (const Element* svg : page.all("svg", "role", "img")) {
    if (svg->all("title").front()->text != "total acceleration") continue;
    const ReadAxis y = y_axis_of(*svg);
    double largest = 0.0;
    const auto line = line_of(*svg, "var(--c0)");
    for (const PixelPoint& at : line) largest = std::max(largest, y.value(at.y));
    CHECK(largest == Approx(450.0).margin(2.0));
    CHECK(line.size() < 2000);
  }
}

TEST_CASE("Every ring and line of a layer is drawn point for point in millimetres, y upwards") {
  const std::vector<report::PicturedLayer> layers{layer(1)};
  const Element page = parse_markup(report::layers_svg(layers));
  const Element& g = page.only("g");
  std::size_t areas = 0, lines = 0;
  for (const Element& path : g.children) {
    const auto drawn = polylines_of(path.attribute("d"));
    if (path.attribute("fill") != "") {
      CHECK(area(drawn.at(0)) == Approx(100.0).margin(0.01));
      ++areas;
      continue;
    }
    const auto line = layers[0].paths.lines[lines];
    REQUIRE(drawn.at(0).size() == line.size() + (layers[0].paths.info[lines].closed ? 1u : 0u));
    for (std::size_t n = 0; n < line.size(); ++n) {
      CHECK(drawn[0][n].x == Approx(line[n].x * geometry::kMmPerUnit).margin(0.0051));
      CHECK(drawn[0][n].y == Approx(-line[n].y * geometry::kMmPerUnit).margin(0.0051));
    }
    ++lines;
  }
  CHECK(areas == 2);
  CHECK(lines == 4);
}

TEST_CASE("Layers of a contact sheet lie beside each other inside the sheet, whatever their number") {
  for (const int count : {1, 2, 3, 7, 12, 30}) {
    std::vector<report::PicturedLayer> layers;
    for (int n = 1; n <= count; ++n) layers.push_back(layer(n));
    const Element page = parse_markup(report::layers_svg(layers));
    double width = 0, height = 0;
    REQUIRE(std::sscanf(page.only("svg").attribute("viewBox").c_str(), "0 0 %lf %lf", &width, &height) == 2);
    std::vector<Box> boxes;
    for (const Element* g : page.all("g")) {
      double left = 0, bottom = 0;
      REQUIRE(std::sscanf(g->attribute("transform").c_str(), "translate(%lf %lf)", &left, &bottom) == 2);
      Box b;
      for (const Element* path : g->all("path"))
        for (const auto& line : polylines_of(path->attribute("d")))
          for (const PixelPoint& at : line) b.take(left + at.x, bottom + at.y);
      CHECK(b.left >= 0.0);
      CHECK(b.top >= 0.0);
      CHECK(b.right <= width);
      CHECK(b.bottom <= height);
      for (const Box& o : boxes) CHECK_FALSE(b.meets(o));
      boxes.push_back(b);
    }
    CHECK(int(boxes.size()) == count);
    CHECK(page.all("text").back()->text == "layer " + std::to_string(count) + ", " + [&] {
      std::ostringstream s;
      s << 0.24 * count;
      return s.str();
    }() + " mm");
  }
}

TEST_CASE("The PNG of a sheet shows part and scaffold in the colours of the SVG") {
  const std::vector<report::PicturedLayer> layers{layer(1)};
  const Element page = parse_markup(report::layers_svg(layers));
  std::vector<std::array<unsigned, 3>> fills;
  for (const Element* path : page.only("g").all("path")) {
    std::array<unsigned, 3> c{};
    if (std::sscanf(path->attribute("fill").c_str(), "#%02x%02x%02x", &c[0], &c[1], &c[2]) == 3)
      fills.push_back(c);
  }
  REQUIRE(fills.size() == 2);
  const ReadPicture p = picture_of(report::layers_png(layers, 800));
  CHECK(p.width == 800);
  std::map<std::array<unsigned, 3>, int> count;
  for (const auto& c : p.pixels) ++count[{c[0], c[1], c[2]}];
  const double cells = double(p.pixels.size());
  CHECK(count[fills[0]] > 0.1 * cells);
  CHECK(count[fills[1]] > 0.1 * cells);
  CHECK(p.at(0, p.height - 1) == std::array<std::uint8_t, 4>{255, 255, 255, 255});
  CHECK(std::abs(count[fills[0]] - count[fills[1]]) < 0.1 * cells);
}

TEST_CASE(
    "A sheet has a bar of its scale, as long as its words say, and at most a quarter of the part's width") {
  const std::vector<report::PicturedLayer> layers{layer(1)};
  const Element page = parse_markup(report::layers_svg(layers));
  const auto bar = polylines_of(page.only("svg").all("path").front()->attribute("d")).at(0);
  REQUIRE(bar.size() == 2);
  double told_mm = 0.0;
  REQUIRE(std::sscanf(page.all("text").front()->text.c_str(), "%lf mm", &told_mm) == 1);
  CHECK(bar[1].x - bar[0].x == Approx(told_mm));
  double from = 1e9, to = -1e9;
  for (const auto& region : layers[0].regions.by_material)
    for (const geometry::Point& p : region.points) {
      from = std::min(from, p.x * geometry::kMmPerUnit);
      to = std::max(to, p.x * geometry::kMmPerUnit);
    }
  CHECK(told_mm <= 0.25 * (to - from));
  CHECK(told_mm > 0.09 * (to - from));
}

TEST_CASE("Pictures of no layer and of layers without lines are drawn") {
  CHECK_NOTHROW(parse_markup(report::layers_svg({})));
  const std::vector<report::PicturedLayer> empty(3);
  CHECK(parse_markup(report::layers_svg(empty)).all("g").size() == 3);
}

TEST_CASE("A layer written as JSON is read by the planner's reader as the same paths") {
  const report::PicturedLayer l = layer(7);
  const std::vector<std::string> tools{"water", ""};
  std::istringstream in(report::layer_json(l.paths, tools));
  std::vector<InputPath> read;
  read_paths_json(in, "layer.json", 1.0, [&](InputPath&& p) { read.push_back(std::move(p)); });
  REQUIRE(read.size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    const slice::PathInfo& info = l.paths.info[n];
    CHECK(read[n].path.kind == info.kind);
    CHECK(read[n].path.layer == 7);
    CHECK(read[n].path.z_mm == Approx(7 * 0.24));
    CHECK(read[n].path.closed == info.closed);
    CHECK(read[n].path.width_mm == Approx(info.width * geometry::kMmPerUnit));
    CHECK(read[n].tool == (info.material == 0 ? "water" : "flange"));
    const auto line = l.paths.lines[n];
    REQUIRE(read[n].path.points.size() == line.size());
    for (std::size_t k = 0; k < line.size(); ++k) {
      CHECK(std::lround(read[n].path.points[k].x_mm * geometry::kUnitsPerMm) == line[k].x);
      CHECK(std::lround(read[n].path.points[k].y_mm * geometry::kUnitsPerMm) == line[k].y);
    }
  }
}

TEST_CASE("A tool's name is read back from a layer's JSON, whatever it contains") {
  const report::PicturedLayer l = layer(7);
  const std::vector<std::string> tools{"water \"1 mm\" \\ \n", "a, {\"tool\": 1}"};
  std::istringstream in(report::layer_json(l.paths, tools));
  std::size_t read = 0;
  read_paths_json(in, "layer.json", 1.0, [&](InputPath&& p) {
    const std::size_t material = l.paths.info[read++].material;
    CHECK(p.tool == (material < tools.size() ? tools[material] : "flange"));
  });
  CHECK(read == l.paths.lines.size());
}

}  // namespace
}  // namespace firn::test
