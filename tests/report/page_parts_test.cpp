// The order of a report's page: one legend, error maps first, parts on axes of their
// own.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "core/grid/outline.h"
#include "core/grid/random.h"
#include "report/draw/charts.h"
#include "report/draw/heat_map.h"
#include "report/run/edge_table.h"
#include "report/run/report_lab.h"
#include "report/run/report_page.h"
#include "tests/report/markup.h"

namespace firn::test {
namespace {

using report::ReportRun;
using report::RunData;

/// A run of a part whose cells are as high as `height_mm`, with an error of `error_mm` everywhere.
RunData made_run(const std::string& scheme, const std::string& part, double height_mm, double error_mm,
                 int layers) {
  RunData r;
  r.scheme = scheme;
  r.folder = scheme;
  r.result = runs::RunResult{"finished"};
  r.part = {part, part, 0.6, 0.4, height_mm};
  for (int n = 0; n <= layers; ++n) {
    report::LayerRow l;
    l.layer = n;
    l.rms_mm = std::abs(error_mm) + 0.001 * (layers - n);
    l.drops = 10;
    l.deposit_s = 1.0;
    l.end_s = n;
    r.layers.push_back(l);
  }
  const GridSpec grid{6, 4, 0.1, 0.1};
  r.target = HeightMap(grid, height_mm);
  r.height = HeightMap(grid, height_mm + error_mm);
  r.mask = Mask(grid, 1);
  r.provenance = {{"run id", "1"}};
  return r;
}

std::vector<std::string> headings(const Element& page) {
  std::vector<std::string> all;
  for (const Element* h : page.all("h2")) all.push_back(h->all_text());
  return all;
}

std::vector<const Element*> drawings(const Element& page, const std::string& title) {
  std::vector<const Element*> all;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->only("title").text == title) all.push_back(svg);
  return all;
}

std::size_t at(const std::vector<std::string>& names, const std::string& name) {
  return std::size_t(std::find(names.begin(), names.end(), name) - names.begin());
}

// The first table of results about the only run of a page, by its column.
std::map<std::string, std::string> first_row(const RunData& run) {
  const Element page = parse_markup(report::report_page({{run, ""}}, {}));
  for (const Element* table : page.all("table")) {
    const auto rows = table_rows(*table);
    if (std::ranges::find(rows[0], "mean error [µm]") == rows[0].end()) continue;
    std::map<std::string, std::string> cells;
    for (std::size_t c = 0; c < rows[0].size(); ++c) cells[rows[0][c]] = rows[1].at(c);
    return cells;
  }
  return {};
}

OutlineStats an_outline(double overspill, double ring_mm, double size_mm) {
  OutlineStats o;
  o.overspill = overspill;
  o.first_ring_mm = ring_mm;
  o.size_error_x_mm = size_mm;
  o.size_error_y_mm = 2.0 * size_mm;
  return o;
}

TEST_CASE("The first table tells the edge of the last map, whatever the true surface is like") {
  RunData run = made_run("mpc", "disc", 0.4, 0.001, 3);
  run.layers.back().measured_outline = an_outline(0.09, 0.2, 0.45);
  run.layers.back().true_outline = an_outline(0.07, 0.1, 0.44);
  auto row = first_row(run);
  CHECK(row["overspill [%]"] == "9");
  CHECK(row["first ring [µm]"] == "200");
  CHECK(row["size error x, y [µm]"] == "450, 900");
  CHECK_FALSE(row.contains("true overspill [%]"));
  run.layers.back().measured_outline->cut = true;
  CHECK(first_row(run)["size error x, y [µm]"] == "≥ 450, 900");
}

TEST_CASE("An edge that no map tells is shown as that of the true surface, and says so") {
  RunData run = made_run("smf", "disc", 0.4, 0.001, 3);
  run.layers.back().true_outline = an_outline(0.07, 0.1, 0.44);
  auto row = first_row(run);
  CHECK(row["true overspill [%]"] == "7");
  CHECK(row["true first ring [µm]"] == "100");
  CHECK(row["true size error x, y [µm]"] == "440, 880");
  CHECK_FALSE(row.contains("overspill [%]"));
}

TEST_CASE(
    "The table of edges names the surface of each row, and has one for a part without maps of its edge") {
  RunData run = made_run("smf", "disc", 0.4, 0.001, 3);
  const std::vector<ReportRun> true_only{{run, ""}};
  CHECK(report::edge_table(true_only, {"smf"}).empty());
  run.layers.back().true_outline = an_outline(0.07, 0.1, 0.44);
  const auto rows = [](const RunData& r) {
    return table_rows(parse_markup(report::edge_table({{r, ""}}, {"smf"})).only("table"));
  };
  REQUIRE(rows(run).size() == 2);
  CHECK(rows(run)[1][1] == "true surface");
  run.layers.back().measured_outline = an_outline(0.09, 0.2, 0.45);
  REQUIRE(rows(run).size() == 3);
  CHECK((rows(run)[1][1] == "last map" && rows(run)[1][2] == "9"));
  CHECK((rows(run)[2][1] == "true surface" && rows(run)[2][2] == "7"));
  run.layers.back().measured_outline->cut = true;
  CHECK(std::ranges::count(rows(run)[1], "≥ 450") == 1);
}

TEST_CASE("The camera has a phase in the time per layer of runs with pictures, and none in others") {
  const auto phases = [](const RunData& run) {
    const Element page = parse_markup(report::report_page({{run, ""}}, {}));
    return page.all("p", "class", "legend").back()->all_text();
  };
  RunData run = made_run("smf", "disc", 0.4, 0.001, 3);
  CHECK(phases(run).find("pictures") == std::string::npos);
  run.layers[2].look_s = 1.0;
  CHECK(phases(run).find("pictures") != std::string::npos);
}

TEST_CASE("The pictures of a recorded run of lines take time in each layer, from the way to the camera on") {
  const RunData run =
      report::read_run_data(FIRN_SOURCE_DIR "/tests/replay/golden/v7-lines", report::kLineReport);
  REQUIRE(run.layers.size() == 3);
  for (const report::LayerRow& l : run.layers) CHECK((l.look_s > 0.05 && l.look_s < l.end_s));
}

TEST_CASE("The error maps are the first figures of a page") {
  const Element page = parse_markup(report::report_page(
      {{made_run("mpc", "disc", 0.4, 0.001, 9), ""}, {made_run("smf", "disc", 0.4, 0.002, 9), ""}}, {}));
  const auto names = headings(page);
  REQUIRE_FALSE(names.empty());
  CHECK(names.front() == "Error of the final surfaces");
  CHECK(at(names, "Final surfaces") < at(names, "Cross-sections"));
  CHECK(page.all("svg", "role", "img").front()->only("title").text == "error of mpc");
}

TEST_CASE(
    "A page has one legend for its lines, which no chart repeats, with each run's line as it is drawn") {
  const std::vector<std::string> schemes{"mpc",     "smf",   "threshold", "open_loop",
                                         "pattern", "a <b>", "seventh",   "eighth"};
  std::vector<ReportRun> runs;
  for (const std::string& s : schemes) runs.push_back({made_run(s, "disc", 0.4, 0.001, 9), ""});
  const Element page = parse_markup(report::report_page(runs, {}));
  const auto legends = page.all("p", "class", "legend");
  REQUIRE(legends.size() == 2);  // of the lines, and of the phases of time
  const auto entries = legends[0]->all("span");
  REQUIRE(entries.size() == schemes.size() + 1);
  const auto charts = drawings(page, "RMS per layer");
  REQUIRE(charts.size() == 1);
  const auto lines = charts[0]->all("path", "stroke-linejoin", "round");
  REQUIRE(lines.size() == schemes.size());
  std::set<std::string> looks;
  for (std::size_t n = 0; n < schemes.size(); ++n) {
    CHECK(entries[n]->all_text().find(schemes[n]) != std::string::npos);
    const Element& sample = *entries[n]->all("path").front();
    CHECK(sample.attribute("stroke") == lines[n]->attribute("stroke"));
    CHECK(sample.attribute("stroke-dasharray") == lines[n]->attribute("stroke-dasharray"));
    looks.insert(sample.attribute("stroke") + sample.attribute("stroke-dasharray"));
  }
  CHECK(looks.size() == schemes.size());
  CHECK(entries.back()->all_text().find("target") != std::string::npos);
  for (const Element* svg : page.all("svg", "role", "img"))
    for (const Element* text : svg->all("text"))
      for (const std::string& s : schemes) CHECK(text->text != s);
}

TEST_CASE("Runs of different parts share no chart, no scale and no comparison") {
  const std::vector<ReportRun> runs{{made_run("mpc", "disc", 0.4, 0.001, 30), ""},
                                    {made_run("smf", "wall", 4.0, 0.050, 300), ""},
                                    {made_run("threshold", "disc", 0.4, 0.002, 40), ""}};
  const Element page = parse_markup(report::report_page(runs, {}));
  const auto parts = page.all("h2", "class", "part");
  REQUIRE(parts.size() == 2);
  CHECK(parts[0]->all_text() == "disc, 0.6 × 0.4 × 0.40 mm");
  CHECK(parts[1]->all_text() == "wall, 0.6 × 0.4 × 4.00 mm");
  const auto charts = drawings(page, "RMS per layer");
  REQUIRE(charts.size() == 2);
  CHECK(charts[0]->all("path", "stroke-linejoin", "round").size() == 2);
  CHECK(charts[1]->all("path", "stroke-linejoin", "round").size() == 1);
  CHECK(x_axis_of(*charts[0]).values().back() <= 40.0);
  CHECK(x_axis_of(*charts[1]).values().back() > 200.0);
  const auto sections = drawings(page, "cross-sections");
  REQUIRE(sections.size() == 2);
  CHECK(y_axis_of(*sections[0]).values().back() < 1000.0);
  CHECK(page.all("span", "class", "best").size() == 1);  // the wall's one run has nothing to be better than
  CHECK(page.only("span", "class", "best").text == "1");
  const std::string all = page.all_text();
  CHECK(all.find("2 times as large") != std::string::npos);
  CHECK(all.find("50 times as large") == std::string::npos);
}

TEST_CASE("One part has no heading of parts, and runs without a known part are one group") {
  CHECK(parse_markup(report::report_page({{made_run("mpc", "disc", 0.4, 0.001, 3), ""}}, {}))
            .all("h2", "class", "part")
            .empty());
  CHECK(parse_markup(report::report_page({{RunData{}, ""}, {RunData{}, ""}}, {}))
            .all("h2", "class", "part")
            .empty());
}

TEST_CASE(
    "One run far off does not blanch the error maps of the others, and the page says how far it is off") {
  std::vector<ReportRun> runs{{made_run("open_loop", "disc", 0.4, -0.090, 9), ""}};
  for (const char* s : {"mpc", "smf", "threshold"}) runs.push_back({made_run(s, "disc", 0.4, 0.002, 9), ""});
  const Element page = parse_markup(report::report_page(runs, {}));
  const auto colour = [&](const std::string& name) {
    return picture_of(drawings(page, "error of " + name).at(0)->only("image")).at(2, 2);
  };
  CHECK(int(colour("mpc")[0]) - int(colour("mpc")[2]) > 80);               // orange
  CHECK(int(colour("open_loop")[2]) - int(colour("open_loop")[0]) > 150);  // the end of blue
  CHECK(page.all_text().find("Larger errors, up to 90 µm") != std::string::npos);
  const Element alone = parse_markup(report::report_page({{made_run("mpc", "disc", 0.4, 0.002, 9), ""}}, {}));
  CHECK(alone.all_text().find("Larger errors") == std::string::npos);
}

TEST_CASE("The outline of a part runs between its cells and the others, and nowhere else") {
  RandomStream random(11, Purpose::kTest);
  for (int trial = 0; trial < 60; ++trial) {
    const GridSpec grid{1 + int(random.below(9)), 1 + int(random.below(9)), 0.5, 0.5};
    Mask part(grid);
    for (auto& c : part.cells) c = std::uint8_t(random.below(2));
    const Element map = parse_markup(report::heat_map(HeightMap(grid, 0.1), {0, 200}, "map", &part));
    const Element& image = map.only("image");
    const double cell = image.at("width") / grid.nx;
    // Edges of cells, in units of half a cell from the low corner: odd along the edge, even across it.
    std::set<std::pair<int, int>> drawn, wanted;
    const std::string d = map.only("path", "class", "outline").attribute("d");
    for (const auto& line : d.empty() ? std::vector<std::vector<PixelPoint>>{} : polylines_of(d)) {
      REQUIRE(line.size() == 2);
      const auto unit = [&](const PixelPoint& p) {
        return std::pair{(p.x - image.at("x")) / cell, (image.at("y") + image.at("height") - p.y) / cell};
      };
      const auto [x0, y0] = unit(line[0]);
      const auto [x1, y1] = unit(line[1]);
      const int steps = int(std::lround(std::abs(x1 - x0) + std::abs(y1 - y0)));
      REQUIRE(steps > 0);
      for (int k = 0; k < steps; ++k) {
        const double share = (k + 0.5) / steps;
        CHECK(drawn
                  .insert({int(std::lround(2 * (x0 + share * (x1 - x0)))),
                           int(std::lround(2 * (y0 + share * (y1 - y0))))})
                  .second);
      }
    }
    const auto in = [&](int i, int j) {
      return i >= 0 && j >= 0 && i < grid.nx && j < grid.ny && part.at(i, j) != 0;
    };
    for (int j = 0; j <= grid.ny; ++j)
      for (int i = 0; i <= grid.nx; ++i) {
        if (i < grid.nx && in(i, j) != in(i, j - 1)) wanted.insert({2 * i + 1, 2 * j});
        if (j < grid.ny && in(i, j) != in(i - 1, j)) wanted.insert({2 * i, 2 * j + 1});
      }
    CHECK(drawn == wanted);
  }
  CHECK(parse_markup(report::heat_map(HeightMap({3, 3, 1, 1}, 0.1), {0, 200}, "map"))
            .all("path", "class", "outline")
            .empty());
}

TEST_CASE("The page's style lets a single figure be no wider than one of three") {
  const std::string page = report::report_page({{made_run("mpc", "disc", 0.4, 0.001, 9), ""}}, {});
  CHECK(page.find("repeat(auto-fill, minmax(min(100%, 360px), 1fr))") != std::string::npos);
  CHECK(page.find("auto-fit") == std::string::npos);
}

}  // namespace
}  // namespace firn::test
