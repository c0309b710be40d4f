// Drawing: the content of a picture is read back from its markup and compared with the data.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/grid/random.h"
#include "report/draw/charts.h"
#include "report/draw/heat_map.h"
#include "report/draw/raster.h"
#include "report/draw/style.h"
#include "report/draw/svg.h"
#include "tests/report/markup.h"

using namespace firn;
using namespace firn::report;
using firn::test::Element;
using firn::test::parse_markup;
using firn::test::PixelPoint;
using firn::test::ReadAxis;
using firn::test::ReadPicture;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Lines of data: paths with stroke-linejoin inside the clipped inner drawing.
std::vector<const Element*> data_lines(const Element& page) {
  return page.all("path", "stroke-linejoin", "round");
}

// The largest distance, in pixels, of a drawn point from the sample that it belongs to.
double worst_px(const std::vector<PixelPoint>& drawn, const std::vector<double>& x,
                const std::vector<double>& y, const ReadAxis& ax, const ReadAxis& ay) {
  double worst = drawn.size() == x.size() ? 0.0 : 1e9;
  for (std::size_t n = 0; n < drawn.size() && n < x.size(); ++n) {
    worst = std::max(worst, std::abs(ax.value(drawn[n].x) - x[n]) / ax.per_px(drawn[n].x));
    worst = std::max(worst, std::abs(ay.value(drawn[n].y) - y[n]) / ay.per_px(drawn[n].y));
  }
  return worst;
}

// An axis' ticks are multiples of 1, 2 or 5 times a power of ten.
bool round_step(double step) {
  const double mantissa = step / std::pow(10.0, std::floor(std::log10(step) + 1e-9));
  for (const double m : {1.0, 2.0, 5.0})
    if (std::abs(mantissa - m) < 1e-6 * m) return true;
  return false;
}

}  // namespace

TEST_CASE("A printed number reads back as the value rounded to its decimals") {
  RandomStream random(11, Purpose::kTest);
  for (int trial = 0; trial < 2000; ++trial) {
    const double size = std::pow(10.0, random.uniform(-6.0, 9.0));
    const double v = size * random.uniform(-1.0, 1.0);
    const int decimals = int(random.below(7));
    const std::string text = report::number(v, decimals);
    CAPTURE(v, decimals, text);
    const double unit = std::pow(10.0, -decimals);
    REQUIRE(std::abs(test::printed_number(text) - v) <= 0.5 * unit * (1.0 + 1e-9) + 1e-12 * std::abs(v));
    REQUIRE(text.find('-') == text.npos);
    REQUIRE((text.find('.') == text.npos) == (decimals == 0));
  }
}

TEST_CASE("No number is printed as minus zero, whatever its decimals") {
  for (int decimals = 0; decimals <= 6; ++decimals) {
    CAPTURE(decimals);
    CHECK(test::printed_number(report::number(-0.0, decimals)) == 0.0);
    CHECK(number(-0.0, decimals) == number(0.0, decimals));
    CHECK(number(-0.49 * std::pow(10.0, -decimals), decimals) == number(0.0, decimals));
  }
}

TEST_CASE("Escaped text comes back unchanged through a reader of markup") {
  RandomStream random(12, Purpose::kTest);
  const std::string letters = "ab<>&\"' ;=/";
  for (int trial = 0; trial < 300; ++trial) {
    std::string text;
    for (std::uint32_t n = random.below(30); n > 0; --n) {
      const char c = letters[random.below(std::uint32_t(letters.size()))];
      text += c;
    }
    CAPTURE(text);
    const Element page =
        parse_markup("<p title=\"" + report::escape_html(text) + "\">" + report::escape_html(text) + "</p>");
    REQUIRE(page.only("p").text == text);
    REQUIRE(page.only("p").attribute("title") == text);
  }
}

TEST_CASE(
    "Ticks of a linear axis are evenly spaced multiples of a round step, none missing inside the range") {
  RandomStream random(13, Purpose::kTest);
  for (int trial = 0; trial < 1000; ++trial) {
    const double size = std::pow(10.0, random.uniform(-9.0, 9.0));
    const double low = size * random.uniform(-1.0, 1.0);
    const double high = low + size * random.uniform(0.01, 1.0);
    const report::Axis axis(low, high, 54, 414, 6);
    CAPTURE(low, high);
    const auto& ticks = axis.ticks();
    REQUIRE(ticks.size() >= 2);
    REQUIRE(ticks.size() <= 8);
    const double step = ticks[1].value - ticks[0].value;
    REQUIRE(round_step(step));
    for (std::size_t n = 0; n < ticks.size(); ++n) {
      REQUIRE(ticks[n].value == Approx(ticks[0].value + double(n) * step).margin(1e-9 * size));
      const double multiple = ticks[n].value / step;
      REQUIRE(std::abs(multiple - std::round(multiple)) < 1e-6);
    }
    REQUIRE(ticks.front().value - step < low - 1e-7 * (high - low));
    REQUIRE(ticks.back().value + step > high + 1e-7 * (high - low));
  }
}

TEST_CASE("A tick's text is its value to the last digit") {
  for (const auto& [low, high] : {std::pair{0.0, 0.07}, {-3.0, 12.0}, {1e4, 9e4}, {0.99, 1.01}}) {
    const report::Axis axis(low, high, 0, 100, 6);
    for (const report::Axis::Tick& t : axis.ticks()) {
      CAPTURE(t.text);
      CHECK(test::printed_number(t.text) == Approx(t.value).epsilon(1e-9).margin(1e-12));
    }
  }
}

TEST_CASE("A range of a few units in the last place has an axis, not an endless one") {
  for (const double base : {1.0, 0.1, 12.5, 1e20, -7.0}) {
    CAPTURE(base);
    double high = base;
    for (int ulp = 0; ulp < 3; ++ulp) {
      high = std::nextafter(high, std::numeric_limits<double>::infinity());
      const report::Axis axis(base, high, 0, 400, 6);
      CHECK(axis.ticks().size() <= 12);
      CHECK(std::isfinite(axis.px(base)));
    }
  }
}

TEST_CASE("An axis of whole numbers has no tick between two of them") {
  for (int high = 1; high < 40; ++high) {
    const report::Axis axis(0.4, high + 0.6, 0, 400, 6, report::Axis::Kind::kWhole);
    CAPTURE(high);
    CHECK(!axis.ticks().empty());
    for (const report::Axis::Tick& t : axis.ticks()) CHECK(t.value == std::round(t.value));
  }
}

TEST_CASE("Equal ratios are equally long on a logarithmic axis") {
  const report::Axis axis(0.03, 700.0, 20, 420, 6, report::Axis::Kind::kLogarithmic);
  const double decade = axis.px(10.0) - axis.px(1.0);
  for (const double v : {0.04, 0.3, 5.0, 60.0}) CHECK(axis.px(10 * v) - axis.px(v) == Approx(decade));
  CHECK(axis.px(0.03) == Approx(20.0));
  CHECK(axis.px(700.0) == Approx(420.0));
  for (const report::Axis::Tick& t : axis.ticks()) CHECK(test::printed_number(t.text) == Approx(t.value));
}

TEST_CASE("A logarithmic axis has at least two ticks, however narrow its range") {
  RandomStream random(15, Purpose::kTest);
  for (int trial = 0; trial < 1000; ++trial) {
    const double low = std::pow(10.0, random.uniform(-6.0, 6.0));
    const double high = low * (1.0 + std::pow(10.0, random.uniform(-4.0, 4.0)));
    CAPTURE(low, high);
    const report::Axis axis(low, high, 20, 420, 6, report::Axis::Kind::kLogarithmic);
    CHECK(axis.ticks().size() >= 2);
    for (const report::Axis::Tick& t : axis.ticks()) {
      CHECK(t.value >= low * 0.998);
      CHECK(t.value <= high * 1.002);
    }
  }
}

TEST_CASE("Every sample of a line chart is drawn where the axes' ticks say") {
  RandomStream random(14, Purpose::kTest);
  for (int trial = 0; trial < 40; ++trial) {
    const double size_x = std::pow(10.0, random.uniform(-3.0, 5.0)),
                 size_y = std::pow(10.0, random.uniform(-3.0, 5.0));
    std::vector<report::Series> series(1 + random.below(4));
    for (std::size_t k = 0; k < series.size(); ++k) {
      report::Series& s = series[k];
      s.label = "run " + std::to_string(k);
      s.style = int(k);
      for (int n = 0; n < 30; ++n) {
        s.x.push_back(size_x * (n + random.uniform()));
        s.y.push_back(size_y * random.uniform(-1.0, 1.0));
      }
    }
    const Element page = parse_markup(report::line_chart(series, {"t", "x [s]", "y [mm]"}));
    const ReadAxis x = test::x_axis_of(page), y = test::y_axis_of(page);
    const auto lines = data_lines(page);
    REQUIRE(lines.size() == series.size());
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const auto drawn = test::polylines_of(lines[k]->attribute("d"));
      REQUIRE(drawn.size() == 1);
      CAPTURE(trial, k, size_x, size_y);
      CHECK(worst_px(drawn[0], series[k].x, series[k].y, x, y) < 0.2);
    }
  }
}

TEST_CASE("A value that is no number breaks its line and leaves no mark") {
  report::Series s{"broken", {0, 1, 2, 3, 4, 5}, {1, 2, kNan, 4, HUGE_VAL, 6}, 0, true};
  const Element page = parse_markup(report::line_chart({s}, {"t", "x", "y"}));
  const auto drawn = test::polylines_of(data_lines(page).at(0)->attribute("d"));
  REQUIRE(drawn.size() == 3);
  CHECK(drawn[0].size() == 2);
  CHECK(drawn[1].size() == 1);
  CHECK(drawn[2].size() == 1);
  CHECK(page.all("circle").size() == 4 + 1);  // one in the legend
}

TEST_CASE("A logarithmic chart draws positive values only, at their logarithms") {
  report::Series s{"decades", {0, 1, 2, 3, 4}, {0.02, 0.0, 3.0, -1.0, 400.0}, 0};
  report::ChartOptions o{"t", "layer", "rms"};
  o.logarithmic = true;
  const Element page = parse_markup(report::line_chart({s}, o));
  const ReadAxis y = test::y_axis_of(page, true);
  std::vector<PixelPoint> points;
  for (const auto& line : test::polylines_of(data_lines(page).at(0)->attribute("d")))
    points.insert(points.end(), line.begin(), line.end());
  REQUIRE(points.size() == 3);
  CHECK(y.value(points[0].y) == Approx(0.02).epsilon(0.01));
  CHECK(y.value(points[1].y) == Approx(3.0).epsilon(0.01));
  CHECK(y.value(points[2].y) == Approx(400.0).epsilon(0.01));
}

TEST_CASE("A chart of nothing, of one point and of equal values is a drawing with axes") {
  const std::vector<std::vector<report::Series>> cases{{},
                                                       {{"empty", {}, {}, 0}},
                                                       {{"one", {3.0}, {4.0}, 0, true}},
                                                       {{"flat", {0, 1, 2}, {7, 7, 7}, 0}},
                                                       {{"none", {0, 1}, {kNan, kNan}, 0}},
                                                       {{"huge", {0, 1}, {-1e300, 1e300}, 0}}};
  for (const auto& series : cases)
    for (const bool logarithmic : {false, true}) {
      report::ChartOptions o{"t", "x", "y"};
      o.logarithmic = logarithmic;
      const Element page = parse_markup(report::line_chart(series, o));
      CAPTURE(series.empty() ? "nothing" : series[0].label, logarithmic);
      CHECK(page.only("svg", "role", "img").all("text", "class", "name").size() == 2);
      for (const Element* line : data_lines(page)) CHECK_NOTHROW(test::polylines_of(line->attribute("d")));
    }
}

TEST_CASE("A given range clips lines at the frame and leaves their positions true") {
  report::Series s{"steep", {0, 1, 2}, {0.0, 5.0, 50.0}, 0};
  report::ChartOptions o{"t", "x", "y"};
  o.y_range = std::pair{0.0, 10.0};
  const Element page = parse_markup(report::line_chart({s}, o));
  const ReadAxis y = test::y_axis_of(page);
  const Element& clip = page.only("svg", "x", "0");
  const auto drawn = test::polylines_of(clip.only("path", "stroke-linejoin", "round").attribute("d"));
  CHECK(y.value(drawn.at(0).at(1).y) == Approx(5.0).margin(0.05));
  CHECK(y.value(drawn.at(0).at(2).y) == Approx(50.0).margin(0.3));
  CHECK(drawn[0][2].y < clip.at("y"));
  CHECK(clip.attribute("viewBox") ==
        "0 " + clip.attribute("y") + " " + clip.attribute("width") + " " + clip.attribute("height"));
}

TEST_CASE("A band encloses its line and is interrupted where it has no bounds") {
  report::Series s{"mean", {0, 1, 2, 3, 4}, {1, 2, 3, 4, 5}, 2};
  s.low = {0.5, 1.0, kNan, 3.0, 4.5};
  s.high = {1.5, 3.0, kNan, 5.0, 5.5};
  const Element page = parse_markup(report::line_chart({s}, {"t", "x", "y"}));
  const auto bands = page.all("path", "fill-opacity", "0.16");
  REQUIRE(bands.size() == 2);
  const ReadAxis x = test::x_axis_of(page), y = test::y_axis_of(page);
  const std::vector<std::vector<std::size_t>> members{{0, 1}, {3, 4}};
  for (std::size_t b = 0; b < 2; ++b) {
    const auto ring = test::polylines_of(bands[b]->attribute("d")).at(0);
    REQUIRE(ring.size() == 5);  // out along low, back along high, closed
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t n = members[b][k];
      CHECK(x.value(ring[k].x) == Approx(s.x[n]).margin(0.02));
      CHECK(y.value(ring[k].y) == Approx(s.low[n]).margin(0.02));
      CHECK(x.value(ring[3 - k].x) == Approx(s.x[n]).margin(0.02));
      CHECK(y.value(ring[3 - k].y) == Approx(s.high[n]).margin(0.02));
    }
  }
}

TEST_CASE("Runs differ in colour and dashes, so that a chart on paper tells six of them apart") {
  std::vector<report::Series> series;
  for (int n = 0; n < 6; ++n) series.push_back({"run", {0, 1}, {0, double(n)}, n});
  series.push_back({"target", {0, 1}, {2, 2}, report::Series::kReference});
  const Element page = parse_markup(report::line_chart(series, {"t", "x", "y"}));
  std::vector<std::string> strokes, dashes;
  for (const Element* line : data_lines(page)) {
    strokes.push_back(line->attribute("stroke"));
    dashes.push_back(line->attribute("stroke-dasharray"));
  }
  for (auto* words : {&strokes, &dashes}) {
    std::sort(words->begin(), words->end());
    CHECK(std::unique(words->begin(), words->end()) == words->end());
  }
}

TEST_CASE("No two of 36 runs have the same colour, dashes and marks") {
  std::vector<report::Series> series;
  for (int n = 0; n < 36; ++n) series.push_back({"run", {0, 1}, {0, double(n)}, n});
  const Element page = parse_markup(report::line_chart(series, {"t", "x", "y"}));
  std::vector<std::string> looks;
  for (const Element* line : data_lines(page))
    looks.push_back(line->attribute("stroke") + " " + line->attribute("stroke-dasharray"));
  CHECK(looks.size() == 36);
  std::sort(looks.begin(), looks.end());
  CHECK(std::unique(looks.begin(), looks.end()) == looks.end());
}

TEST_CASE("A legend names every series once, inside the drawing") {
  std::vector<report::Series> series;
  for (int n = 0; n < 9; ++n) series.push_back({"scheme <" + std::to_string(n) + ">", {0, 1}, {0, 1}, n});
  report::ChartOptions o{"t", "x", "y"};
  o.shaded = {{0.2, 0.4}};
  o.shaded_label = "closed";
  const Element page = parse_markup(report::line_chart(series, o));
  const Element& svg = page.only("svg", "role", "img");
  double width = 0, height = 0;
  REQUIRE(std::sscanf(svg.attribute("viewBox").c_str(), "0 0 %lf %lf", &width, &height) == 2);
  int named = 0;
  for (const Element* g : svg.all("g")) {
    double x = 0, y = 0;
    if (g->attribute("transform").find("rotate") != std::string::npos) continue;
    REQUIRE(std::sscanf(g->attribute("transform").c_str(), "translate(%lf %lf)", &x, &y) == 2);
    CHECK(x >= 0.0);
    CHECK(x < width);
    CHECK(y > 250.0);
    CHECK(y < height);
    ++named;
  }
  CHECK(named == 10);
  CHECK(page.all_text().find("scheme <8>") != std::string::npos);
}

TEST_CASE("Shaded spans lie over the times that they stand for") {
  report::Series s{"speed", {0, 10}, {0, 1}, 0};
  report::ChartOptions o{"t", "x", "y"};
  o.shaded = {{1.0, 2.5}, {7.0, 10.0}};
  const Element page = parse_markup(report::line_chart({s}, o));
  const ReadAxis x = test::x_axis_of(page);
  const auto rects = page.all("rect", "fill-opacity", "0.18");
  REQUIRE(rects.size() == 2);
  for (std::size_t n = 0; n < 2; ++n) {
    CHECK(x.value(rects[n]->at("x")) == Approx(o.shaded[n].first).margin(0.02));
    CHECK(x.value(rects[n]->at("x") + rects[n]->at("width")) == Approx(o.shaded[n].second).margin(0.02));
  }
}

TEST_CASE("Bars stack their parts without gaps, and each is as high as its value on the axis") {
  RandomStream random(15, Purpose::kTest);
  report::Bars bars;
  bars.parts = {"deposit", "cure", "scan", "decide"};
  bars.heights.resize(4);
  double top = 0.0;
  for (int n = 0; n < 12; ++n) {
    bars.x.push_back(n);
    double sum = 0.0;
    for (auto& part : bars.heights) {
      part.push_back(random.below(5) == 0 ? 0.0 : random.uniform(0.1, 3.0));
      sum += part.back();
    }
    top = std::max(top, sum);
  }
  const Element page = parse_markup(report::bar_chart(bars, top, {"t", "layer", "time [s]"}));
  const ReadAxis x = test::x_axis_of(page), y = test::y_axis_of(page);
  std::vector<double> reached(12, 0.0);
  std::size_t drawn = 0, wanted = 0;
  for (std::size_t p = 0; p < 4; ++p) {
    std::vector<const Element*> rects = page.all("rect", "fill", "var(--p" + std::to_string(p) + ")");
    rects.pop_back();  // the legend's
    std::size_t k = 0;
    for (std::size_t n = 0; n < 12; ++n) {
      if (bars.heights[p][n] == 0.0) continue;
      ++wanted;
      const Element& r = *rects.at(k++);
      CHECK(x.value(r.at("x") + 0.5 * r.at("width")) == Approx(double(n)).margin(0.02));
      CHECK(y.value(r.at("y") + r.at("height")) == Approx(reached[n]).margin(0.02 * top));
      reached[n] += bars.heights[p][n];
      CHECK(y.value(r.at("y")) == Approx(reached[n]).margin(0.02 * top));
    }
    drawn += rects.size();
  }
  CHECK(drawn == wanted);
}

TEST_CASE("A pixel of a raster is the same after PNG, base 64 and back") {
  RandomStream random(16, Purpose::kTest);
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 3}, {7, 5}, {64, 33}}) {
    report::Raster raster(width, height);
    for (report::Rgba& c : raster.pixels)
      for (std::uint8_t& v : c) v = std::uint8_t(random.below(256));
    for (report::Rgba& c : raster.pixels) c[3] = 255;
    const Element page = parse_markup(report::svg_image(raster, 3.0, 4.0, 50.0, 60.0));
    const ReadPicture read = test::picture_of(page.only("image"));
    REQUIRE(read.width == width);
    REQUIRE(read.height == height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) REQUIRE(read.at(x, y) == raster.at(x, y));
    CHECK(page.only("image").at("height") == 60.0);
  }
}

TEST_CASE("A heat map has one pixel a cell, y upwards, and nothing where nothing was measured") {
  const GridSpec grid{5, 3, 0.05, 0.05, 1.0, 2.0};
  HeightMap map(grid, 0.010);
  map.at(0, 0) = 0.0;
  map.at(4, 2) = 0.020;
  map.at(2, 1) = kNotMeasured;
  const Element page =
      parse_markup(report::heat_map(map, {0.0, 20.0, report::ColorMap::kSequential}, "height"));
  const ReadPicture read = test::picture_of(page.only("image"));
  REQUIRE(read.width == 5);
  REQUIRE(read.height == 3);
  CHECK(read.at(2, 1)[3] == 0);
  const ReadPicture bar = test::picture_of(
      parse_markup(report::color_bar({0.0, 20.0, report::ColorMap::kSequential}, "height [µm]"))
          .only("image"));
  REQUIRE(bar.width == 256);
  CHECK(read.at(0, 2) == bar.at(0, 0));
  CHECK(read.at(4, 0) == bar.at(255, 0));
  CHECK(read.at(1, 1) == bar.at(128, 0));
}

TEST_CASE("Lightness rises all along the sequential colour scale") {
  const ReadPicture bar = test::picture_of(
      parse_markup(report::color_bar({0.0, 1.0, report::ColorMap::kSequential}, "h")).only("image"));
  double before = -1.0;
  int falls = 0;
  for (int n = 0; n < 256; ++n) {
    const auto c = bar.at(n, 0);
    const double lightness = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];  // Rec. 709
    falls += lightness < before - 1.0;
    before = lightness;
  }
  CHECK(falls == 0);
}

TEST_CASE(
    "The diverging scale is nearly white in its middle, blue below and orange above, alike far from white") {
  const ReadPicture bar = test::picture_of(
      parse_markup(report::color_bar({-5.0, 5.0, report::ColorMap::kDiverging}, "e")).only("image"));
  const auto low = bar.at(0, 0), high = bar.at(255, 0);
  for (int c = 0; c < 3; ++c) CHECK(bar.at(127, 0)[std::size_t(c)] > 240);
  CHECK(low[2] > low[0] + 100);
  CHECK(high[0] > high[2] + 100);
  for (int n = 0; n < 127; ++n) {
    CHECK(bar.at(n, 0)[0] <= bar.at(n + 1, 0)[0]);
    CHECK(bar.at(255 - n, 0)[2] <= bar.at(254 - n, 0)[2]);
  }
}

TEST_CASE("Ticks of a heat map stand at the coordinates of its cells") {
  const GridSpec grid{40, 20, 0.1, 0.1, -1.0, 3.0};
  const Element page = parse_markup(report::heat_map(HeightMap(grid, 0.001), {0.0, 2.0}, "h"));
  const Element& image = page.only("image");
  const ReadAxis x = test::x_axis_of(page), y = test::y_axis_of(page);
  CHECK(x.value(image.at("x")) == Approx(grid.x_mm(0) - 0.05).margin(0.02));
  CHECK(x.value(image.at("x") + image.at("width")) == Approx(grid.x_mm(39) + 0.05).margin(0.02));
  CHECK(y.value(image.at("y")) == Approx(grid.y_mm(19) + 0.05).margin(0.02));
  CHECK(y.value(image.at("y") + image.at("height")) == Approx(grid.y_mm(0) - 0.05).margin(0.02));
}

TEST_CASE("Heights beyond the scale have the colours of its ends") {
  HeightMap map({3, 1, 1.0, 1.0}, 0.0);
  map.cells = {-1.0, 1e6, 0.0};
  const Element page = parse_markup(report::heat_map(map, {-10.0, 10.0, report::ColorMap::kDiverging}, "h"));
  const ReadPicture read = test::picture_of(page.only("image"));
  const ReadPicture bar = test::picture_of(
      parse_markup(report::color_bar({-10.0, 10.0, report::ColorMap::kDiverging}, "h")).only("image"));
  CHECK(read.at(0, 0) == bar.at(0, 0));
  CHECK(read.at(1, 0) == bar.at(255, 0));
}

TEST_CASE("A drawing that stands alone holds every colour that it names") {
  report::Series s{"a", {0, 1}, {0, 1}, 0, true};
  const std::string alone = report::standalone_svg(report::line_chart({s}, {"t", "x", "y"}));
  const Element page = parse_markup(alone);
  const std::string& css = page.only("style").text;
  for (std::size_t at = alone.find("var(--"); at != alone.npos; at = alone.find("var(--", at + 1)) {
    const std::string name = alone.substr(at + 4, alone.find(')', at) - at - 4);
    CAPTURE(name);
    CHECK(css.find(name + ":") != css.npos);
  }
  CHECK(report::standalone_svg("<p>no drawing</p>") == "<p>no drawing</p>");
  CHECK(report::standalone_svg("<svg") == "<svg");
}
