// Conclusions of a study, on tables whose truth is known.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/grid/random.h"
#include "core/statistics/sign_flip.h"
#include "report/study/study_analysis.h"
#include "report/study/study_page.h"
#include "report/study/study_plots.h"
#include "report/study/study_profile.h"

using namespace firn;
using namespace firn::report;
using firn::statistics::smallest_p;

namespace {

// Each seed has a day of its own that all arms share; `shift` is the effect of an arm.
report::StudyTable made(const std::vector<double>& shift, std::size_t seeds, double own_noise,
                        std::uint64_t key = 1, std::size_t parts = 2) {
  report::StudyTable t;
  t.name = "made";
  t.metrics = {{"rms_um", "um", "RMS error", 2}, {"layers", "", "layers", 1}};
  for (std::size_t a = 0; a < shift.size(); ++a) t.arms.push_back("arm" + std::to_string(a));
  for (std::size_t p = 0; p < parts; ++p) t.parts.push_back("part" + std::to_string(p));
  for (std::size_t s = 0; s < seeds; ++s) t.seeds.push_back(s + 1);
  RandomStream random(key, Purpose::kTest);
  std::vector<double> day(seeds);
  for (double& d : day) d = 10.0 + 2.0 * random.normal();
  for (std::size_t a = 0; a < shift.size(); ++a)
    for (std::size_t p = 0; p < parts; ++p)
      for (std::size_t s = 0; s < seeds; ++s)
        t.runs.push_back(
            {true, "finished", "", {day[s] + double(p) + shift[a] + own_noise * random.normal(), 50.0}});
  return t;
}

bool says(const report::StudyAnalysis& a, const std::string& words) {
  return a.answer.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("the same scheme under two names is not distinguishable") {
  const report::StudyTable t = made({0.0, 0.0}, 30, 0.0);
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "not distinguishable"));
  CHECK(says(a, "equal for all 30 seeds"));
  CHECK(a.primary(0, 1).holm_p == 1.0);
}

TEST_CASE("The answer names up to six schemes that cannot be told apart, and counts more") {
  for (const std::size_t arms : {6u, 7u, 20u}) {
    const report::StudyAnalysis a = report::analyse(made(std::vector<double>(arms, 0.0), 30, 0.0, 1, 1));
    CAPTURE(a.answer);
    CHECK(says(a, "arm5") == (arms == 6));
    CHECK(says(a, "and " + std::to_string(arms - 1) + " other schemes are not") == (arms > 6));
  }
}

TEST_CASE("schemes of equal quality are not distinguishable, whatever their noise") {
  int wrong = 0;
  for (std::uint64_t key = 1; key <= 20; ++key)
    wrong += !says(report::analyse(made({0.0, 0.0}, 20, 1.0, key, 1)), "not distinguishable");
  CHECK(wrong <= 3);  // 1 of 20 is expected; 4 or more has a chance of 2 %
}

TEST_CASE("a planted difference is found, with its size inside the interval") {
  const report::StudyTable t = made({1.0, 0.0, 0.4}, 40, 0.3);
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "arm1 is better"));
  CHECK(says(a, "below arm2"));
  CHECK(says(a, "40 seeds"));
  const report::ArmComparison& c = a.primary(0, 1);
  CHECK(c.holm_p < 0.001);
  CHECK(c.values.interval.low < 1.0);
  CHECK(c.values.interval.high > 1.0);
  // Days differ by 2 um: without pairs 0.4 um would drown.
  CHECK(a.primary(1, 2).holm_p < 0.01);
  CHECK(a.ranking == std::vector<std::size_t>{1, 2, 0});
}

TEST_CASE("two good schemes that cannot be told apart are named together, and what they beat") {
  report::StudyTable t = made({0.0, 0.0, 5.0}, 30, 0.5);
  t.baseline = "arm2";
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "are not distinguishable"));
  CHECK(says(a, "is better than arm2 by"));
  CHECK(a.answer.find('\n') == std::string::npos);
}

TEST_CASE("the unit is the seed: parts that repeat one difference do not make it surer") {
  const report::StudyTable one = made({0.3, 0.0}, 12, 1.0, 5, 1);
  report::StudyTable five = one;
  five.parts = {"a", "b", "c", "d", "e"};
  five.runs.clear();
  for (std::size_t arm = 0; arm < 2; ++arm)
    for (int part = 0; part < 5; ++part)
      for (std::size_t s = 0; s < 12; ++s) five.runs.push_back(one.run(arm, 0, s));
  CHECK(report::analyse(five).primary(0, 1).values.p == Approx(report::analyse(one).primary(0, 1).values.p));
  CHECK(report::analyse(five).primary(0, 1).values.pairs == 12);
}

TEST_CASE("parts that go opposite ways are told, though their mean shows nothing") {
  report::StudyTable t = made({0.0, 0.0}, 30, 0.05);
  for (std::size_t s = 0; s < 30; ++s) {
    t.runs[s].metrics[0] -= 1.0;
    t.runs[30 + s].metrics[0] += 1.0;
  }
  const report::StudyAnalysis a = report::analyse(t);
  CHECK(says(a, "not distinguishable"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("The parts disagree") != std::string::npos);
  const bool first = a.ranking[0] == 0;  // the note begins with the one of smaller mean
  CHECK(a.notes[0].find(first ? "arm0 is better on part0 by" : "arm1 is better on part1 by") !=
        std::string::npos);
  CHECK(a.notes[0].find(first ? "arm1 on part1 by" : "arm0 on part0 by") != std::string::npos);
  CHECK(report::analyse(made({0.0, 1.0}, 30, 0.05)).notes.empty());
}

TEST_CASE("Prints that stopped are counted and told, and are in no mean") {
  report::StudyTable t = made({1.0, 0.0}, 30, 0.1);
  for (std::size_t s = 0; s < 4; ++s)
    t.runs[s] = {false, "waits for operator", "max_layers", {0.001, 1.0}};  // would flatter arm0
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(a.stopped == std::vector<int>{4, 0});
  CHECK(a.out == std::vector<int>{0, 0});
  const report::ArmComparison& c = a.primary(0, 1);
  CHECK(c.left_out == 0);  // each seed has a part that both completed
  CHECK(c.failed_a == 4);
  CHECK(c.failures_p == Approx(2.0 / 16.0));
  CHECK(c.values.difference == Approx(1.0).margin(0.1));
  CHECK(c.better() == 1);
  CHECK(says(a, "arm1 is better"));
  CHECK(says(a, "arm0: 4 of 60 prints stopped"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("arm0: 4 of 60 prints stopped") != std::string::npos);
  const std::string page = report::study_page({t, a, {}, {}, {}});
  CHECK(page.find("Prints that stopped or ended out of tolerance: 4") != std::string::npos);
  CHECK(page.find("failed prints 4 : 0") != std::string::npos);
  CHECK(page.find(">4 failed<") != std::string::npos);
}

TEST_CASE("One stop among ten prints does not hide a difference that every other seed shows") {
  for (const double of_stopped : {0.001, 400.0}) {  // the surface it left, early or late
    report::StudyTable t = made({0.91, 48.8}, 10, 0.1, 3, 1);
    t.runs[4] = {false, "stopped safely", "nozzle", {of_stopped, 1.0}};
    const report::StudyAnalysis a = report::analyse(t);
    CAPTURE(a.answer);
    CHECK(a.primary(0, 1).values.p == 2.0 / 512.0);
    CHECK(a.primary(0, 1).failures_p == 1.0);
    CHECK(a.ranking == std::vector<std::size_t>{0, 1});
    CHECK(says(a, "arm0 is better"));
    CHECK(says(a, "1 of 10 prints stopped"));
  }
}

TEST_CASE("A print that a guard stops within tolerance counts with the part that it left") {
  report::StudyTable t = made({0.9, 1.4}, 10, 0.1, 3, 1);
  t.runs[4].finished = false;
  t.runs[4].within = true;
  const report::StudyAnalysis a = report::analyse(t);
  CHECK(a.stopped == std::vector<int>{1, 0});
  CHECK(a.primary(0, 1).values.pairs == 10);
  CHECK(a.primary(0, 1).failed_a == 0);
}

TEST_CASE("A finished print out of tolerance is marked and counts against its scheme, whatever the metric") {
  report::StudyTable t = made({0.0, 1.0}, 12, 0.1, 3, 1);
  for (std::size_t s = 0; s < 24; ++s) t.runs[s].within = s >= 12;  // arm0 is short, and looks better
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(a.out == std::vector<int>{12, 0});
  CHECK(a.primary(0, 1).failures_p == smallest_p(12));
  CHECK(says(a, "all 12 OUT OF TOLERANCE"));
  CHECK_FALSE(says(a, "arm0 is better"));
  CHECK(report::study_page({t, a, {}, {}, {}}).find("OUT OF TOLERANCE") != std::string::npos);
  CHECK(report::study_csv(t).find(",within_tolerance,") != std::string::npos);
}

TEST_CASE("A scheme that is far behind and stops on three of eight seeds is told apart") {
  report::StudyTable t = made({0.0, 0.02, 0.03, 6.0}, 8, 0.1);
  t.baseline = "arm3";
  for (std::size_t s = 0; s < 3; ++s)
    t.runs[(3 * 2 + 1) * 8 + s] = {false, "stopped safely", "nozzle", {0.2, 1.0}};  // young: still small
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  for (std::size_t arm = 0; arm < 3; ++arm) {
    CHECK(a.primary(arm, 3).values.p == 2.0 / 256.0);
    CHECK(a.primary(arm, 3).told_apart());
    CHECK(a.primary(arm, 3).better() == arm);
  }
  CHECK(a.ranking.back() == 3);
  CHECK(says(a, "arm3: 3 of 16 prints stopped"));
}

TEST_CASE("A p that no result of as many seeds could be below is called the smallest possible") {
  const report::StudyTable sure = made({1.0, 0.0}, 10, 0.01);
  const report::StudyAnalysis a = report::analyse(sure);
  CAPTURE(a.answer);
  CHECK(a.primary(0, 1).values.p == smallest_p(10));
  CHECK(a.primary(0, 1).at_smallest_p());
  CHECK(says(a, "(Holm p = 0.002, 10 seeds, the smallest possible)"));
  CHECK(report::study_page({sure, a, {}, {}, {}}).find("(smallest possible)") != std::string::npos);
  const report::StudyTable vague = made({0.3, 0.0}, 10, 0.3, 2);
  const report::StudyAnalysis b = report::analyse(vague);
  CAPTURE(b.answer, b.primary(0, 1).values.p);
  CHECK(b.primary(0, 1).values.p > smallest_p(10));
  CHECK_FALSE(b.primary(0, 1).at_smallest_p());
  CHECK_FALSE(says(b, "smallest"));
  CHECK(report::study_page({vague, b, {}, {}, {}}).find("smallest") == std::string::npos);
  CHECK_FALSE(report::analyse(made({1.0, 0.0}, 1, 0.0)).primary(0, 1).at_smallest_p());  // one seed: always 1
}

TEST_CASE("A scheme whose errors are small where it does not stop is not the better one for that") {
  report::StudyTable t = made({0.0, 1.0}, 20, 0.1, 3, 1);
  for (std::size_t s = 0; s < 19; ++s) t.runs[s] = {false, "stopped safely", "nozzle", {0.1, 1.0}};
  const report::StudyAnalysis a = report::analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "arm1 is better"));
  CHECK(a.primary(0, 1).values.difference < 0.0);  // of the one complete seed
  CHECK(a.ranking == std::vector<std::size_t>{1, 0});
  CHECK(report::study_page({t, a, {}, {}, {}}).find("arm1 is better") != std::string::npos);
}

TEST_CASE(
    "Stops of either scheme alike tell nothing, and a test with stops is the same when the two change "
    "places") {
  report::StudyTable t = made({0.0, 0.0}, 20, 1.0, 4, 1);
  for (std::size_t s = 0; s < 5; ++s) t.runs[s].finished = t.runs[20 + 5 + s].finished = false;
  const report::StudyAnalysis a = report::analyse(t);
  CHECK(says(a, "not distinguishable"));
  report::StudyTable turned = t;
  std::rotate(turned.runs.begin(), turned.runs.begin() + 20, turned.runs.end());
  const report::StudyAnalysis b = report::analyse(turned);
  CHECK(a.primary(0, 1).values.p == b.primary(0, 1).values.p);
  CHECK(a.primary(0, 1).failures_p == b.primary(0, 1).failures_p);
  CHECK(a.primary(0, 1).lead == -b.primary(0, 1).lead);
  CHECK(a.primary(0, 1).values.a_below_b == Approx(1.0 - b.primary(0, 1).values.a_below_b));
}

TEST_CASE("An arm that never finished is behind all others, and with none left there is nothing to compare") {
  report::StudyTable t = made({0.0, 1.0}, 10, 0.1);
  for (std::size_t n = 0; n < 20; ++n) t.runs[n] = {false, "error", "no", {NAN, NAN}};
  const report::StudyAnalysis half = report::analyse(t);
  CAPTURE(half.answer);
  CHECK(half.ranking == std::vector<std::size_t>{1, 0});
  CHECK(half.primary(0, 1).failures_p == smallest_p(10));
  CHECK(says(half, "arm1 is better"));
  CHECK(says(half, "arm0: all 20 prints stopped"));
  CHECK_FALSE(says(half, "nan"));
  for (auto& r : t.runs) r.finished = false;
  const report::StudyAnalysis none = report::analyse(t);
  CHECK(none.ranking.empty());
  CHECK(says(none, "nothing can be compared"));
  CHECK(!report::study_page({t, none, {}, {}, {}}).empty());
  report::StudyTable one = made({0.0, 1.0}, 1, 0.1);
  one.runs[0].finished = false;
  CHECK(says(report::analyse(one), "not distinguishable"));
  CHECK_FALSE(says(report::analyse(one), "nan"));
}

TEST_CASE("too few seeds to tell anything are told as such") {
  const report::StudyAnalysis a = report::analyse(made({5.0, 0.0}, 4, 0.1));
  CHECK(says(a, "not distinguishable"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("4 seeds cannot tell 1 pair apart") != std::string::npos);
  CHECK(report::analyse(made({5.0, 0.0}, 6, 0.1)).notes.empty());
  const report::StudyAnalysis one = report::analyse(made({5.0, 0.0}, 1, 0.1));
  CHECK(says(one, "1 seed)"));
  CHECK(!says(one, "nan"));
  CHECK(report::analyse(made({5.0}, 6, 0.1)).notes.empty());
}

TEST_CASE("page and CSV hold every arm, escape what names hold, and are the same bytes each time") {
  report::StudyTable t = made({1.0, 0.0}, 8, 0.2);
  t.arms[0] = "a <b>\"c\"";
  t.runs[3].reason = "said \"no\", twice";
  const report::StudyAnalysis a = report::analyse(t);
  const report::StudyPage page{t, a, {{"control.scheme", "", {"mpc", "smf"}}}, {}, {{"build", "x"}}};
  const std::string html = report::study_page(page);
  CHECK(html.find("a &lt;b&gt;") != std::string::npos);
  CHECK(html.find("<b>\"c\"") == std::string::npos);
  CHECK(html.find("control.scheme") != std::string::npos);
  CHECK(html.find("http://www.w3.org/2000/svg") != std::string::npos);
  CHECK(html.find("src=") == std::string::npos);
  CHECK(html == report::study_page(page));
  const std::string csv = report::study_csv(t);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 32);
  CHECK(csv.find("\"a <b>\"\"c\"\"\"") != std::string::npos);
  CHECK(csv.find("\"said \"\"no\"\", twice\"") != std::string::npos);
}

TEST_CASE("The page says what a seed fixes in its lab, and holds no pair of which one does not measure") {
  report::StudyTable t = made({2.0, 1.0, 0.0}, 8, 0.2, 1, 1);
  for (std::size_t seed = 0; seed < 8; ++seed) t.runs[seed].metrics[1] = NAN;
  const report::StudyAnalysis a = report::analyse(t);
  report::StudyPage page{t, a, {}, {}, {}};
  CHECK(report::study_page(page).find("the same seed. Blue") != std::string::npos);
  page.nature = "the wind";
  const std::string html = report::study_page(page);
  CHECK(html.find("the same seed, and the wind. Blue") != std::string::npos);
  const auto count = [&](const std::string& pair) {
    std::size_t n = 0;
    for (std::size_t at = html.find(pair); at != std::string::npos; at = html.find(pair, at + 1)) ++n;
    return n;
  };
  CHECK(count("<td>arm0 – arm1</td>") == 1);
  CHECK(count("<td>arm1 – arm2</td>") == 2);
}

TEST_CASE("A profile has a row for each place, over the seeds that came so far") {
  report::StudyTable t = made({0.0, 1.0}, 9, 0.3, 1, 1);
  CHECK(report::profile_rows(t).empty());
  CHECK(report::profile_text(t, {}).empty());
  CHECK(report::profile_section(t, {}).empty());
  t.profile = {"RMS against height", "height_mm", "rms_um"};
  for (std::size_t arm = 0; arm < 2; ++arm)
    for (std::size_t seed = 0; seed < 9; ++seed) {
      report::StudyRun& r = t.runs[arm * 9 + seed];
      r.profile = {{1.2, 10.0 * double(arm + 1) + double(seed)}, {2.4, 100.0}, {3.6, NAN}};
      if (arm == 1 && seed > 2) r.profile.resize(1);  // stopped
    }
  const std::vector<report::ProfileRow> rows = report::profile_rows(t);
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].x == 1.2);
  CHECK(rows[0].seeds == 9);
  CHECK(rows[0].mean == Approx(14.0));
  CHECK(rows[0].interval.low < 14.0);
  CHECK(rows[0].interval.high > 14.0);
  CHECK(rows[0].least == 10.0);
  CHECK(rows[0].largest == 18.0);
  CHECK(rows[1].interval.low == 100.0);
  CHECK(rows[3].arm == 1);
  CHECK(rows[3].seeds == 3);
  CHECK(report::profile_csv(t, rows).find("\"arm1\",\"part0\",2.4,3,100,100,100,100,100\n") !=
        std::string::npos);
  CHECK(report::profile_text(t, rows).find("100.0 [100.0, 100.0] 100.0") != std::string::npos);
  CHECK(report::profile_section(t, rows).find("RMS against height") != std::string::npos);
}

TEST_CASE("Accuracy against time has a mark for each scheme that finished") {
  report::StudyTable t = made({0.0, 1.0, 2.0}, 9, 0.3, 1, 1);
  t.metrics[1] = {"time_h", "h", "time", 2};
  for (std::size_t seed = 0; seed < 9; ++seed) t.runs[18 + seed].finished = false;
  const std::string plot = report::trade_off_plot(t, report::analyse(t), 1, 0);
  CHECK(plot.find(">arm0<") != std::string::npos);
  CHECK(plot.find(">arm1<") != std::string::npos);
  CHECK(plot.find(">arm2<") == std::string::npos);
}
