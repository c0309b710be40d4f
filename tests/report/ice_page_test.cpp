// The report's sections for runs on ice, from made data whose pictures are known.
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <limits>

#include "core/grid/random.h"
#include "report/run/report_data.h"
#include "report/run/report_ice.h"
#include "tests/report/markup.h"

using namespace firn;
using namespace firn::report;
using firn::test::Element;
using firn::test::parse_markup;
using firn::test::ReadAxis;
using firn::test::ReadPicture;

namespace {

const GridSpec kGrid{12, 10, 1.0, 1.0, -6.0, -5.0};

// Interval n at n * 1.2 mm, its measured surface off by `error_mm` everywhere, the true one by twice that.
report::IceInterval interval(int n, double error_mm, bool with_truth) {
  report::IceInterval i;
  i.layer = 5 * n;
  i.nominal_mm = 1.2 * n;
  i.height = HeightMap(kGrid, i.nominal_mm + error_mm);
  if (with_truth) i.truth = HeightMap(kGrid, i.nominal_mm + 2.0 * error_mm);
  i.footprint = Mask(kGrid, 1);
  i.saturated_fraction = 0.01 * n;
  return i;
}

Element page_of(const report::IceData& data, const std::string& name = "kalman") {
  return parse_markup("<div>" + report::ice_sections({{name, &data}}) + "</div>");
}

const Element& drawing(const Element& page, const std::string& title) {
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->only("title").text == title) return *svg;
  throw std::runtime_error("no drawing " + title);
}

std::vector<test::PixelPoint> line_of(const Element& chart) {
  return test::polylines_of(chart.only("path", "stroke-linejoin", "round").attribute("d")).at(0);
}

double luma(const std::array<std::uint8_t, 4>& c) { return 0.3 * c[0] + 0.59 * c[1] + 0.11 * c[2]; }

ReadPicture relief(const HeightMap& h, double step_mm) {
  return test::picture_of(parse_markup(report::shaded_relief(h, step_mm, "relief")).only("image"));
}

}  // namespace

TEST_CASE("RMS deviation is drawn at each interval's height, measured and true apart") {
  report::IceData data;
  const std::vector<double> errors{0.05, -0.20, 0.10, 0.30};
  for (std::size_t n = 0; n < errors.size(); ++n)
    data.intervals.push_back(interval(int(n) + 1, errors[n], true));
  const Element page = page_of(data);
  const Element &measured = drawing(page, "RMS against height"),
                &truth = drawing(page, "true RMS against height");
  for (const auto& [chart, factor] : {std::pair{&measured, 1.0}, {&truth, 2.0}}) {
    const ReadAxis x = test::x_axis_of(*chart), y = test::y_axis_of(*chart);
    const auto line = line_of(*chart);
    REQUIRE(line.size() == errors.size());
    for (std::size_t n = 0; n < line.size(); ++n) {
      CHECK(x.value(line[n].x) == Approx(1.2 * double(n + 1)).margin(0.02));
      CHECK(y.value(line[n].y) == Approx(factor * std::abs(errors[n])).margin(0.005));
    }
  }
}

TEST_CASE("The share of saturated cells is drawn in per cent") {
  report::IceData data;
  for (int n = 1; n <= 5; ++n) data.intervals.push_back(interval(n, 0.1, false));
  const Element page = page_of(data);
  const Element& chart = drawing(page, "saturated cells");
  const ReadAxis y = test::y_axis_of(chart);
  const auto line = line_of(chart);
  REQUIRE(line.size() == 5);
  for (std::size_t n = 0; n < 5; ++n) CHECK(y.value(line[n].y) == Approx(double(n + 1)).margin(0.05));
}

TEST_CASE("Without a true surface the maps show the measured one, and no true chart is drawn") {
  report::IceData data;
  data.intervals = {interval(1, 0.25, false)};
  const Element page = page_of(data);
  CHECK_THROWS(drawing(page, "true RMS against height"));
  CHECK(page.all_text().find("1.20 mm, RMS inside 0.25 mm") != std::string::npos);
  report::IceData with;
  with.intervals = {interval(1, 0.25, true)};
  CHECK(page_of(with).all_text().find("1.20 mm, RMS inside 0.5 mm") != std::string::npos);
}

TEST_CASE("At most six intervals are mapped, the last one always, in order and spread over the height") {
  for (const int count : {1, 2, 5, 6, 7, 12, 13, 40}) {
    report::IceData data;
    for (int n = 1; n <= count; ++n) data.intervals.push_back(interval(n, 0.1, true));
    std::vector<double> heights;
    const Element page = page_of(data);
    for (const Element* figure : page.all("figure", "class", "map"))
      heights.push_back(std::stod(figure->only("figcaption").text));
    CAPTURE(count);
    REQUIRE(int(heights.size()) == std::min(count, 6));
    CHECK(heights.back() == Approx(1.2 * count));
    double widest = 0.0, before = 0.0;
    for (const double h : heights) {
      CHECK(h > before);
      widest = std::max(widest, h - before);
      before = h;
    }
    CHECK(widest <= 1.2 * (std::ceil(count / 6.0) + 1e-9));
  }
}

TEST_CASE("Error maps leave out what is not judged and scale by all but the worst half per cent") {
  report::IceData data;
  report::IceInterval i = interval(1, 0.0, false);
  RandomStream random(51, Purpose::kTest);
  for (double& h : i.height.cells) h += random.uniform(-0.1, 0.1);
  i.height.at(3, 4) = 100.0;  // one wild cell
  i.footprint.at(0, 0) = 0;
  data.intervals = {i};
  const Element page = page_of(data);
  const Element& map = drawing(page, "error of kalman");
  const ReadPicture p = test::picture_of(map.only("image"));
  CHECK(p.at(0, 9)[3] == 0);
  CHECK(p.at(1, 9)[3] == 255);
  const ReadAxis bar = test::x_axis_of(drawing(page, "height − nominal [mm]"));
  CHECK(std::abs(bar.values().back()) <= 0.1);  // not of 100 mm
  CHECK(bar.values().front() == Approx(-bar.values().back()));
}

TEST_CASE("Speed and frequency along a path are drawn over its own time") {
  report::IceData data;
  report::IcePathCurve c;
  c.path = 17;
  c.layer = 9;
  for (int n = 0; n < 50; ++n) {
    c.time_s.push_back(0.1 * n);
    c.speed_mm_s.push_back(40.0 * std::sin(0.06 * n));
    c.pulse_s.push_back(0.1 * n);
    c.frequency_hz.push_back(5.0 + n);
  }
  data.curve = c;
  const Element page = page_of(data);
  for (const auto& [title, wanted] :
       {std::pair{"path speed", &c.speed_mm_s}, {"valve frequency", &c.frequency_hz}}) {
    const Element& chart = drawing(page, title);
    const ReadAxis x = test::x_axis_of(chart), y = test::y_axis_of(chart);
    const auto line = line_of(chart);
    REQUIRE(line.size() == 50);
    for (std::size_t n = 0; n < 50; n += 7) {
      CHECK(x.value(line[n].x) == Approx(0.1 * double(n)).margin(0.01));
      CHECK(y.value(line[n].y) == Approx((*wanted)[n]).margin(0.2));
    }
  }
  CHECK(page.all_text().find("path 17 of layer 9") != std::string::npos);
}

TEST_CASE("A run that measured nothing yet has sections without maps, and no run has none") {
  const report::IceData nothing;
  const Element page = page_of(nothing, "<new>");
  CHECK(page.all("image").empty());
  CHECK(!page.all("h2").empty());
  CHECK(report::ice_sections({}).empty());
}

TEST_CASE("Slopes toward the upper left are lighter than level ground, slopes away from it darker") {
  const GridSpec grid{20, 20, 1.0, 1.0};
  const auto slope = [&](double dx, double dy) {
    HeightMap h(grid);
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) h.at(i, j) = 10.0 + dx * i + dy * j;
    return luma(relief(h, 0.0).at(10, 10));
  };
  // Light comes from (-1, 1): ground that rises to the right or falls upwards turns to it.
  const double level = slope(0.0, 0.0);
  CHECK(slope(0.3, 0.0) > level);
  CHECK(slope(0.0, -0.3) > level);
  CHECK(slope(-0.3, 0.0) < level);
  CHECK(slope(0.0, 0.3) < level);
}

TEST_CASE("Contour lines run half way between whole steps, once for each step of a slope") {
  HeightMap h({101, 3, 1.0, 1.0});
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 101; ++i) h.at(i, j) = 0.06 * i;  // 6 mm: five steps of 1.2
  const ReadPicture with = relief(h, 1.2), without = relief(h, 0.0);
  std::vector<int> lines;
  for (int i = 0; i < 101; ++i)
    if (luma(with.at(i, 1)) < 0.9 * luma(without.at(i, 1))) lines.push_back(i);
  REQUIRE(lines.size() == 5);
  for (std::size_t n = 0; n < 5; ++n) CHECK(0.06 * lines[n] == Approx(1.2 * (double(n) + 0.5)).margin(0.07));
}

TEST_CASE(
    "Cells without a height are transparent in a relief, and those beside them keep the look of level "
    "ground") {
  HeightMap h({9, 9, 1.0, 1.0}, 2.0);
  h.at(4, 4) = kNotMeasured;
  const ReadPicture p = relief(h, 1.2);
  CHECK(p.at(4, 4)[3] == 0);
  for (const auto& [x, y] : {std::pair{3, 4}, {4, 5}, {5, 4}, {4, 3}, {0, 0}}) {
    CAPTURE(x, y);
    CHECK(p.at(x, y) == p.at(8, 8));
  }
}

TEST_CASE("A relief of nothing measured, and one of a single cell, are drawings") {
  CHECK(relief(HeightMap({4, 4, 1.0, 1.0}, kNotMeasured), 1.2).at(2, 2)[3] == 0);
  CHECK(relief(HeightMap({1, 1, 1.0, 1.0}, 1.0), 1.2).at(0, 0)[3] == 255);
  CHECK(relief(HeightMap({2, 1, 1.0, 1.0}, -5.0), 1.2).at(0, 0)[3] == 255);
}
