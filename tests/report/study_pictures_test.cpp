// Pages, plots and tables of studies, read back and compared with the table of runs.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/grid/random.h"
#include "report/study/study_analysis.h"
#include "report/study/study_page.h"
#include "report/study/study_plots.h"
#include "report/study/study_profile.h"
#include "tests/report/markup.h"

using namespace firn;
using namespace firn::report;
using firn::test::Element;
using firn::test::parse_markup;
using firn::test::ReadAxis;

namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// Random prints: arms `apart` from each other, a share of them stopped.
report::StudyTable random_table(std::uint64_t key, std::size_t arms, std::size_t parts, std::size_t seeds,
                                double apart, double stopped) {
  report::StudyTable t;
  t.name = "random";
  t.metrics = {{"rms_um", "um", "RMS error", 2}, {"time_h", "h", "time", 2}};
  for (std::size_t a = 0; a < arms; ++a) t.arms.push_back("arm" + std::to_string(a));
  for (std::size_t p = 0; p < parts; ++p) t.parts.push_back("part" + std::to_string(p));
  for (std::size_t s = 0; s < seeds; ++s) t.seeds.push_back(100 + s);
  RandomStream random(key, Purpose::kTest);
  for (std::size_t a = 0; a < arms; ++a)
    for (std::size_t p = 0; p < parts; ++p)
      for (std::size_t s = 0; s < seeds; ++s) {
        const bool ends = random.uniform() >= stopped;
        t.runs.push_back(
            {ends,
             ends ? "finished" : "stopped safely",
             ends ? "" : "nozzle",
             {10.0 + apart * double(a) + random.normal(), 1.0 + double(a) + 0.1 * random.uniform()}});
      }
  return t;
}

std::vector<test::PixelPoint> dots_of(const Element& svg, std::size_t arm) {
  std::vector<test::PixelPoint> out;
  for (const Element* c : svg.all("circle", "fill", "var(--c" + std::to_string(arm % 6) + ")"))
    out.push_back({c->at("cx"), c->at("cy")});
  return out;
}

const Element& table_with(const Element& page, const std::string& head) {
  for (const Element* table : page.all("table"))
    if (table->all("th").front()->all_text() == head) return *table;
  throw std::runtime_error("no table that begins with " + head);
}

}  // namespace

TEST_CASE("A summary is the mean over the seeds whose prints are all complete") {
  for (std::uint64_t key = 1; key <= 10; ++key) {
    const report::StudyTable t = random_table(key, 3, 2, 9, 0.5, 0.2);
    const report::StudyAnalysis a = report::analyse(t);
    for (const report::ArmSummary& s : a.summaries) {
      double sum = 0.0;
      std::size_t seeds = 0;
      for (std::size_t seed = 0; seed < 9; ++seed) {
        double value = 0.0;
        int count = 0;
        bool complete = true;
        for (std::size_t p = 0; p < 2; ++p) {
          if (s.part != report::kAllParts && p != std::size_t(s.part)) continue;
          complete = complete && t.run(s.arm, p, seed).finished;
          value += t.run(s.arm, p, seed).metrics[s.metric];
          ++count;
        }
        if (!complete) continue;
        sum += value / count;
        ++seeds;
      }
      CAPTURE(key, s.arm, s.part, s.metric);
      CHECK(s.seeds == seeds);
      if (seeds > 0) CHECK(s.mean == Approx(sum / double(seeds)));
    }
  }
}

TEST_CASE("Every pair of arms is compared once for each metric and part, and Holm never lowers a p value") {
  const report::StudyTable t = random_table(3, 4, 3, 8, 0.3, 0.1);
  const report::StudyAnalysis a = report::analyse(t);
  std::map<std::array<std::size_t, 3>, int> seen;
  for (const report::ArmComparison& c : a.comparisons) {
    CHECK(c.a < c.b);
    CHECK(c.holm_p >= c.values.p);
    CHECK(c.holm_p <= 1.0);
    ++seen[{c.a * 10 + c.b, c.metric, std::size_t(c.part + 1)}];
  }
  CHECK(seen.size() == 6 * 2 * 4);
  for (const auto& [key, count] : seen) CHECK(count == 1);
}

TEST_CASE("Within a family Holm's values are those of its definition") {
  for (std::uint64_t key = 1; key <= 8; ++key) {
    const report::StudyAnalysis a = report::analyse(random_table(key, 4, 1, 10, 0.4, 0.0));
    std::vector<const report::ArmComparison*> family;
    for (const report::ArmComparison& c : a.comparisons)
      if (c.metric == 0 && c.part == report::kAllParts) family.push_back(&c);
    REQUIRE(family.size() == 6);
    for (const report::ArmComparison* c : family) {
      // The largest of (m - rank) p over all hypotheses that are no less clear than this one.
      double want = 0.0;
      for (const report::ArmComparison* o : family) {
        if (o->values.p > c->values.p) continue;
        int smaller = 0;
        for (const report::ArmComparison* q : family) smaller += q->values.p < o->values.p;
        want = std::max(want, std::min(1.0, (6.0 - smaller) * o->values.p));
      }
      CHECK(c->holm_p == Approx(want));
    }
  }
}

TEST_CASE("A change of unit changes no test, and scales means and differences") {
  const report::StudyTable t = random_table(4, 3, 2, 10, 0.5, 0.1);
  report::StudyTable milli = t;
  for (report::StudyRun& r : milli.runs) r.metrics[0] *= 1024.0;  // exact in binary
  const report::StudyAnalysis a = report::analyse(t), b = report::analyse(milli);
  CHECK(a.ranking == b.ranking);
  for (std::size_t n = 0; n < a.comparisons.size(); ++n) {
    const report::ArmComparison &x = a.comparisons[n], &y = b.comparisons[n];
    if (x.metric != 0) continue;
    CHECK(x.holm_p == y.holm_p);
    CHECK(1024.0 * x.values.difference == Approx(y.values.difference));
  }
}

TEST_CASE("The order of the seeds does not change which arm is better nor how sure that is") {
  const report::StudyTable t = random_table(5, 3, 2, 9, 0.6, 0.1);
  report::StudyTable turned = t;
  for (std::size_t row = 0; row < 6; ++row)
    std::reverse(turned.runs.begin() + std::ptrdiff_t(row * 9),
                 turned.runs.begin() + std::ptrdiff_t(row * 9 + 9));
  const report::StudyAnalysis a = report::analyse(t), b = report::analyse(turned);
  CHECK(a.ranking == b.ranking);
  for (std::size_t n = 0; n < a.comparisons.size(); ++n)
    CHECK(a.comparisons[n].holm_p == Approx(b.comparisons[n].holm_p));
}

TEST_CASE("Each finished print is a dot at its value, in the row of its arm") {
  const report::StudyTable t = random_table(6, 4, 2, 12, 1.5, 0.15);
  const Element page = parse_markup(report::distribution_plot(t, report::analyse(t), 1, 0));
  const ReadAxis x = test::x_axis_of(page);
  std::vector<double> rows;
  for (const Element* text : page.all("text", "text-anchor", "end"))
    if (text->text.rfind("arm", 0) == 0) rows.push_back(text->at("y") - 4.0);
  REQUIRE(rows.size() == 4);
  for (std::size_t arm = 0; arm < 4; ++arm) {
    std::vector<double> wanted, drawn;
    for (std::size_t s = 0; s < 12; ++s)
      if (t.run(arm, 1, s).finished) wanted.push_back(t.run(arm, 1, s).metrics[0]);
    for (const auto& dot : dots_of(page, arm)) {
      drawn.push_back(x.value(dot.x));
      CHECK(std::abs(dot.y - rows[arm]) <= 0.25 * (rows[1] - rows[0]));
    }
    REQUIRE(drawn.size() == wanted.size());
    std::sort(wanted.begin(), wanted.end());
    std::sort(drawn.begin(), drawn.end());
    for (std::size_t n = 0; n < drawn.size(); ++n) CHECK(drawn[n] == Approx(wanted[n]).margin(0.02));
  }
}

TEST_CASE("The axis of all prints is logarithmic where they differ more than twentyfold, and says so") {
  report::StudyTable t = random_table(7, 2, 1, 10, 0.0, 0.0);
  for (std::size_t s = 0; s < 10; ++s) t.runs[s].metrics[0] *= 100.0;
  const Element wide = parse_markup(report::distribution_plot(t, report::analyse(t), report::kAllParts, 0));
  CHECK(wide.only("text", "class", "name").text == "rms_um, logarithmic");
  std::vector<double> px, values;
  for (const Element* text : wide.all("text", "text-anchor", "middle"))
    if (text->attribute("class") == "tick") {
      px.push_back(text->at("x"));
      values.push_back(test::printed_number(text->text));
    }
  const ReadAxis x(px, values, true);
  std::vector<double> wanted, drawn;
  for (std::size_t s = 0; s < 10; ++s) wanted.push_back(t.runs[s].metrics[0]);
  for (const auto& dot : dots_of(wide, 0)) drawn.push_back(x.value(dot.x));
  std::sort(wanted.begin(), wanted.end());
  std::sort(drawn.begin(), drawn.end());
  REQUIRE(drawn.size() == 10);
  for (std::size_t n = 0; n < 10; ++n) CHECK(drawn[n] == Approx(wanted[n]).epsilon(0.01));
  const report::StudyTable near = random_table(7, 2, 1, 10, 0.0, 0.0);
  CHECK(parse_markup(report::distribution_plot(near, report::analyse(near), report::kAllParts, 0))
            .only("text", "class", "name")
            .text == "rms_um");
}

TEST_CASE("An arm's bar in the plot of all prints is its mean and interval") {
  const report::StudyTable t = random_table(8, 3, 1, 15, 2.0, 0.0);
  const report::StudyAnalysis a = report::analyse(t);
  const Element page = parse_markup(report::distribution_plot(t, a, 0, 0));
  const ReadAxis x = test::x_axis_of(page);
  const auto bars = page.all("path", "stroke", "var(--fg)");
  REQUIRE(bars.size() == 6);  // interval and mean of three arms
  for (std::size_t arm = 0; arm < 3; ++arm) {
    const auto interval = test::polylines_of(bars[2 * arm]->attribute("d")).at(0),
               mean = test::polylines_of(bars[2 * arm + 1]->attribute("d")).at(0);
    const report::ArmSummary& s = a.summaries[arm];
    CHECK(x.value(interval[0].x) == Approx(s.interval.low).margin(0.02));
    CHECK(x.value(interval[1].x) == Approx(s.interval.high).margin(0.02));
    CHECK(x.value(mean[0].x) == Approx(s.mean).margin(0.02));
  }
}

TEST_CASE(
    "The forest plot shows each pair's difference in per cent of the larger mean, left where the first is "
    "better") {
  const report::StudyTable t = random_table(9, 4, 1, 14, 1.0, 0.0);
  const report::StudyAnalysis a = report::analyse(t);
  std::vector<const report::ArmComparison*> pairs;
  for (const report::ArmComparison& c : a.comparisons)
    if (c.metric == 0) pairs.push_back(&c);
  const Element page = parse_markup(report::forest_plot(t, pairs));
  const ReadAxis x = test::x_axis_of(page);
  std::vector<const Element*> bars;
  for (const Element* path : page.all("path"))
    if (path->attribute("stroke-width") == "3") bars.push_back(path);
  REQUIRE(bars.size() == 2 * pairs.size());
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const auto& v = pairs[n]->values;
    const double scale = 100.0 / std::max(v.mean_a, v.mean_b);
    const auto interval = test::polylines_of(bars[2 * n]->attribute("d")).at(0),
               mean = test::polylines_of(bars[2 * n + 1]->attribute("d")).at(0);
    CAPTURE(n);
    CHECK(x.value(mean[0].x) == Approx(scale * v.difference).margin(0.1));
    CHECK(x.value(interval[0].x) == Approx(scale * v.interval.low).margin(0.1));
    CHECK(x.value(interval[1].x) == Approx(scale * v.interval.high).margin(0.1));
    CHECK((bars[2 * n]->attribute("stroke") == "var(--c0)") == (pairs[n]->holm_p <= report::kAlpha));
  }
}

TEST_CASE("Names of any length and any script leave a page of valid text") {
  for (const std::string& letter :
       {std::string("a"), std::string("é"), std::string("層"), std::string("🧊")})
    for (std::size_t length = 1; length < 48; ++length) {
      report::StudyTable t = random_table(10, 2, 1, 4, 1.0, 0.0);
      for (std::size_t n = 0; n < length; ++n) t.arms[0] += letter;
      const report::StudyAnalysis a = report::analyse(t);
      CAPTURE(letter, length);
      REQUIRE_NOTHROW(parse_markup(report::distribution_plot(t, a, 0, 0)));
      REQUIRE_NOTHROW(parse_markup(report::forest_plot(t, {&a.comparisons[0]})));
      t.runs[0].profile = {{1.0, 2.0}};
      REQUIRE_NOTHROW(parse_markup("<p>" + report::profile_text(t, report::profile_rows(t)) + "</p>"));
    }
}

TEST_CASE("Accuracy against time puts each arm's mark at its two means") {
  const report::StudyTable t = random_table(11, 5, 1, 9, 0.7, 0.0);
  const report::StudyAnalysis a = report::analyse(t);
  const Element page = parse_markup(report::trade_off_plot(t, a, 1, 0));
  const ReadAxis x = test::x_axis_of(page), y = test::y_axis_of(page);
  for (std::size_t arm = 0; arm < 5; ++arm) {
    const auto dots = dots_of(page, arm);
    REQUIRE(dots.size() == 1);
    double rms = 0.0, hours = 0.0;
    for (std::size_t s = 0; s < 9; ++s) {
      rms += t.run(arm, 0, s).metrics[0] / 9.0;
      hours += t.run(arm, 0, s).metrics[1] / 9.0;
    }
    CHECK(x.value(dots[0].x) == Approx(hours).margin(0.02));
    CHECK(y.value(dots[0].y) == Approx(rms).margin(0.1));
  }
}

TEST_CASE("Labels of marks that lie on each other do not cover one another") {
  report::StudyTable t = random_table(12, 6, 1, 5, 0.0, 0.0);
  for (report::StudyRun& r : t.runs) r.metrics = {10.0, 2.0};
  const Element page = parse_markup(report::trade_off_plot(t, report::analyse(t), 1, 0));
  std::vector<double> heights;
  for (const Element* text : page.all("text", "text-anchor", "start"))
    if (text->text.rfind("arm", 0) == 0) heights.push_back(text->at("y"));
  REQUIRE(heights.size() == 6);
  std::sort(heights.begin(), heights.end());
  for (std::size_t n = 1; n < 6; ++n) CHECK(heights[n] - heights[n - 1] >= 13.9);
}

TEST_CASE("runs.csv reads back as the table: every print, its outcome and its exact metrics") {
  report::StudyTable t = random_table(13, 3, 2, 4, 0.5, 0.3);
  t.runs[5].metrics[1] = kNoValue;
  t.runs[7].reason = "line one\nline \"two\", end";
  t.arms[2] = "mpc, \"weighted\"";
  const auto rows = test::csv_rows(report::study_csv(t));
  REQUIRE(rows.size() == 1 + t.runs.size());
  CHECK(rows[0] == std::vector<std::string>{"scheme", "part", "seed", "finished", "outcome",
                                            "within_tolerance", "rms_um", "time_h", "reason"});
  for (std::size_t n = 0; n < t.runs.size(); ++n) {
    const auto& row = rows[n + 1];
    CHECK(row[0] == t.arms[n / 8]);
    CHECK(row[1] == t.parts[n / 4 % 2]);
    CHECK(row[2] == std::to_string(t.seeds[n % 4]));
    CHECK(row[3] == (t.runs[n].finished ? "1" : "0"));
    CHECK(row[4] == t.runs[n].outcome);
    CHECK(row[5].empty() == !t.runs[n].within.has_value());
    CHECK(std::stod(row[6]) == t.runs[n].metrics[0]);
    CHECK(row[7].empty() == std::isnan(t.runs[n].metrics[1]));
    CHECK(row[8] == t.runs[n].reason);
  }
}

TEST_CASE("profile.csv has mean, interval and extremes of each place, and no interval of a single seed") {
  report::StudyTable t = random_table(14, 2, 1, 6, 1.0, 0.0);
  t.profile = {"RMS against height", "height_mm", "rms_um"};
  for (std::size_t n = 0; n < 12; ++n) {
    t.runs[n].profile = {{1.0, 5.0 + double(n)}};
    if (n == 0) t.runs[n].profile.push_back({2.0, 7.0});
  }
  const auto rows = report::profile_rows(t);
  REQUIRE(rows.size() == 3);
  const auto csv = test::csv_rows(report::profile_csv(t, rows));
  REQUIRE(csv.size() == 4);
  CHECK(csv[0][2] == "height_mm");
  CHECK(csv[1][3] == "6");
  CHECK(std::stod(csv[1][4]) == Approx(7.5));
  CHECK(std::stod(csv[1][5]) < 7.5);
  CHECK(std::stod(csv[1][6]) > 7.5);
  CHECK(std::stod(csv[1][7]) == 5.0);
  CHECK(std::stod(csv[1][8]) == 10.0);
  CHECK(csv[2][3] == "1");
  CHECK(csv[2][5].empty());
  CHECK(std::stod(csv[3][4]) == Approx(13.5));
}

TEST_CASE("The page's table of schemes repeats the summaries and marks the first of the ranking") {
  const report::StudyTable t = random_table(15, 3, 2, 8, 1.0, 0.0);
  const report::StudyAnalysis a = report::analyse(t);
  const Element page = parse_markup(report::study_page({t, a, {}, {}, {{"commit", "abc"}}}));
  const Element& table = table_with(page, "scheme");
  const auto rows = test::table_rows(table);
  REQUIRE(rows.size() == 4);
  for (std::size_t arm = 0; arm < 3; ++arm) {
    CHECK(rows[arm + 1][0] == t.arms[arm]);
    CHECK(rows[arm + 1][1] == "8");
    CHECK(std::stod(rows[arm + 1][2]) == Approx(a.summaries[arm].mean).margin(0.0051));
  }
  CHECK(std::stod(table.only("span", "class", "best").all_text()) ==
        Approx(a.summaries[a.ranking[0]].mean).margin(0.0051));
  CHECK(page.all("b").at(0)->text == a.answer);
}

TEST_CASE("The page's table of pairs says that a scheme is better exactly where Holm's p is at most 5 %") {
  for (std::uint64_t key = 1; key <= 6; ++key) {
    const report::StudyTable t = random_table(key, 4, 1, 9, 0.5, 0.1);
    const report::StudyAnalysis a = report::analyse(t);
    const Element page = parse_markup(report::study_page({t, a, {}, {}, {}}));
    const auto rows = test::table_rows(table_with(page, "pair"));
    REQUIRE(rows.size() == 7);
    std::size_t n = 1;
    for (const report::ArmComparison& c : a.comparisons) {
      if (c.metric != 0) continue;
      const auto& row = rows[n++];
      CHECK(row[0] == t.arms[c.a] + " – " + t.arms[c.b]);
      CHECK(row.back() ==
            (c.holm_p > report::kAlpha ? "not distinguishable" : t.arms[c.better()] + " is better"));
    }
  }
}

TEST_CASE("A page lists at most fifty prints that did not finish, and counts all") {
  const report::StudyTable t = random_table(16, 3, 2, 20, 0.5, 0.9);
  std::size_t stopped = 0;
  for (const report::StudyRun& r : t.runs) stopped += !r.finished;
  REQUIRE(stopped > 50);
  const Element page = parse_markup(report::study_page({t, report::analyse(t), {}, {}, {}}));
  bool counted = false;
  for (const Element* h : page.all("h2"))
    counted =
        counted || h->text == "Prints that stopped or ended out of tolerance: " + std::to_string(stopped);
  CHECK(counted);
  for (const Element* table : page.all("table", "class", "text"))
    if (table->all("th").size() == 5) CHECK(table->all("tr").size() == 51);
}

TEST_CASE("With many schemes only pairs with the best or the baseline are drawn, and all are in the table") {
  report::StudyTable t = random_table(17, 8, 1, 6, 1.0, 0.0);
  t.baseline = "arm5";
  const report::StudyAnalysis a = report::analyse(t);
  const Element page = parse_markup(report::study_page({t, a, {}, {}, {}}));
  CHECK(test::table_rows(table_with(page, "pair")).size() == 1 + 28);
  const Element* forest = nullptr;
  for (const Element* svg : page.all("svg", "role", "img"))
    if (svg->only("title").text == "paired differences") forest = svg;
  REQUIRE(forest);
  int rows = 0;
  for (const Element* text : forest->all("text", "text-anchor", "end")) {
    if (text->text.find(" – ") == std::string::npos) continue;
    ++rows;
    const bool named = text->text.find(t.arms[a.ranking[0]]) != std::string::npos ||
                       text->text.find("arm5") != std::string::npos;
    CHECK(named);
  }
  CHECK(rows == 7 + 6);
}

TEST_CASE("A p value is printed with as many digits as it can bear") {
  CHECK(report::p_text(0.0004) == "< 0.001");
  CHECK(report::p_text(0.001) == "= 0.001");
  CHECK(report::p_text(0.0456) == "= 0.046");
  CHECK(report::p_text(0.28) == "= 0.28");
  CHECK(report::p_text(1.0) == "= 1.00");
}
