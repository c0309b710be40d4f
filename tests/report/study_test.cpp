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
using namespace firn::replay;
using firn::statistics::smallest_p;

namespace {

// Each seed has a day of its own that all arms share; `shift` is the effect of an arm.
StudyTable made(const std::vector<double>& shift, std::size_t seeds, double own_noise, std::uint64_t key = 1,
                std::size_t parts = 2) {
  StudyTable t;
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

bool says(const StudyAnalysis& a, const std::string& words) {
  return a.answer.find(words) != std::string::npos;
}

}  // namespace

TEST_CASE("the same scheme under two names is not distinguishable") {
  const StudyTable t = made({0.0, 0.0}, 30, 0.0);
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "not distinguishable"));
  CHECK(says(a, "equal for all 30 seeds"));
  CHECK(a.primary(0, 1).holm_p == 1.0);
}

TEST_CASE("schemes of equal quality are not distinguishable, whatever their noise") {
  int wrong = 0;
  for (std::uint64_t key = 1; key <= 20; ++key)
    wrong += !says(analyse(made({0.0, 0.0}, 20, 1.0, key, 1)), "not distinguishable");
  CHECK(wrong <= 3);  // 1 of 20 is expected; 4 or more has a chance of 2 %
}

TEST_CASE("a planted difference is found, with its size inside the interval") {
  const StudyTable t = made({1.0, 0.0, 0.4}, 40, 0.3);
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "arm1 is better"));
  CHECK(says(a, "below arm2"));
  CHECK(says(a, "40 seeds"));
  const ArmComparison& c = a.primary(0, 1);
  CHECK(c.holm_p < 0.001);
  CHECK(c.values.interval.low < 1.0);
  CHECK(c.values.interval.high > 1.0);
  // Days differ by 2 um: without pairs 0.4 um would drown.
  CHECK(a.primary(1, 2).holm_p < 0.01);
  CHECK(a.ranking == std::vector<std::size_t>{1, 2, 0});
}

TEST_CASE("two good schemes that cannot be told apart are named together, and what they beat") {
  StudyTable t = made({0.0, 0.0, 5.0}, 30, 0.5);
  t.baseline = "arm2";
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "are not distinguishable"));
  CHECK(says(a, "is better than arm2 by"));
  CHECK(a.answer.find('\n') == std::string::npos);
}

TEST_CASE("the unit is the seed: parts that repeat one difference do not make it surer") {
  const StudyTable one = made({0.3, 0.0}, 12, 1.0, 5, 1);
  StudyTable five = one;
  five.parts = {"a", "b", "c", "d", "e"};
  five.runs.clear();
  for (std::size_t arm = 0; arm < 2; ++arm)
    for (int part = 0; part < 5; ++part)
      for (std::size_t s = 0; s < 12; ++s) five.runs.push_back(one.run(arm, 0, s));
  CHECK(analyse(five).primary(0, 1).values.p == Approx(analyse(one).primary(0, 1).values.p));
  CHECK(analyse(five).primary(0, 1).values.pairs == 12);
}

TEST_CASE("parts that go opposite ways are told, though their mean shows nothing") {
  StudyTable t = made({0.0, 0.0}, 30, 0.05);
  for (std::size_t s = 0; s < 30; ++s) {
    t.runs[s].metrics[0] -= 1.0;
    t.runs[30 + s].metrics[0] += 1.0;
  }
  const StudyAnalysis a = analyse(t);
  CHECK(says(a, "not distinguishable"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("The parts disagree") != std::string::npos);
  const bool first = a.ranking[0] == 0;  // the note begins with the one of smaller mean
  CHECK(a.notes[0].find(first ? "arm0 is better on part0 by" : "arm1 is better on part1 by") !=
        std::string::npos);
  CHECK(a.notes[0].find(first ? "arm1 on part1 by" : "arm0 on part0 by") != std::string::npos);
  CHECK(analyse(made({0.0, 1.0}, 30, 0.05)).notes.empty());
}

TEST_CASE("Prints that stopped are counted and told, rank behind every complete one, and are in no mean") {
  StudyTable t = made({1.0, 0.0}, 30, 0.1);
  for (std::size_t s = 0; s < 4; ++s)
    t.runs[s] = {false, "waits for operator", "max_layers", {0.001, 1.0}};  // would flatter arm0
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  CHECK(a.failed == std::vector<int>{4, 0});
  const ArmComparison& c = a.primary(0, 1);
  CHECK(c.left_out == 4);
  CHECK(c.tested == 30);
  CHECK(c.stopped_a == 4);
  CHECK(c.values.pairs == 26);
  CHECK(c.values.difference == Approx(1.0).margin(0.1));
  CHECK(c.better() == 1);
  CHECK(says(a, "arm1 is better"));
  CHECK(says(a, "arm0: 4 of 60 prints stopped"));
  CHECK(says(a, "over the 26 seeds that both completed"));
  CHECK(says(a, "30 seeds, a stopped print ranked last"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("4 of 60 prints of arm0 stopped") != std::string::npos);
  const std::string page = study_page({t, a, {}, {}, {}});
  CHECK(page.find("Prints that did not finish: 4") != std::string::npos);
  CHECK(page.find("26 complete; prints stopped 4 : 0") != std::string::npos);
  CHECK(page.find("4 of 60 prints stopped; means of the survivors") != std::string::npos);
  CHECK(page.find(">4 stopped<") != std::string::npos);
}

TEST_CASE(
    "Four schemes on eight seeds: an arm that is far behind and stops on three is told apart, though five "
    "seeds alone could not") {
  StudyTable t = made({0.0, 0.02, 0.03, 6.0}, 8, 0.1);
  t.baseline = "arm3";
  for (std::size_t s = 0; s < 3; ++s)
    t.runs[(3 * 2 + 1) * 8 + s] = {false, "stopped safely", "nozzle", {0.2, 1.0}};  // young: still small
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  for (std::size_t arm = 0; arm < 3; ++arm) {
    CHECK(a.primary(arm, 3).values.p == 2.0 / 256.0);
    CHECK(a.primary(arm, 3).holm_p <= kAlpha);
    CHECK(a.primary(arm, 3).better() == arm);
  }
  CHECK(a.ranking.back() == 3);
  CHECK(says(a, "is better than arm3 (3 of 16 prints stopped; over"));
  CHECK(says(a, "over the 5 seeds that both completed"));
}

TEST_CASE("A p that no result of as many seeds could be below is called the smallest possible") {
  const StudyTable sure = made({1.0, 0.0}, 10, 0.01);
  const StudyAnalysis a = analyse(sure);
  CAPTURE(a.answer);
  CHECK(a.primary(0, 1).values.p == smallest_p(10));
  CHECK(a.primary(0, 1).at_smallest_p());
  CHECK(says(a, "(Holm p = 0.002, 10 seeds, the smallest possible)"));
  CHECK(study_page({sure, a, {}, {}, {}}).find("(smallest possible)") != std::string::npos);
  const StudyTable vague = made({0.3, 0.0}, 10, 0.3, 2);
  const StudyAnalysis b = analyse(vague);
  CAPTURE(b.answer, b.primary(0, 1).values.p);
  CHECK(b.primary(0, 1).values.p > smallest_p(10));
  CHECK_FALSE(b.primary(0, 1).at_smallest_p());
  CHECK_FALSE(says(b, "smallest"));
  CHECK(study_page({vague, b, {}, {}, {}}).find("smallest") == std::string::npos);
  CHECK_FALSE(analyse(made({1.0, 0.0}, 1, 0.0)).primary(0, 1).at_smallest_p());  // one seed: always 1
}

TEST_CASE("A scheme whose errors are small where it does not stop is not the better one for that") {
  StudyTable t = made({0.0, 1.0}, 20, 0.1, 3, 1);
  for (std::size_t s = 0; s < 19; ++s) t.runs[s] = {false, "stopped safely", "nozzle", {0.1, 1.0}};
  const StudyAnalysis a = analyse(t);
  CAPTURE(a.answer);
  CHECK(says(a, "arm1 is better"));
  CHECK(a.primary(0, 1).values.difference < 0.0);  // of the one complete seed
  CHECK(a.ranking == std::vector<std::size_t>{1, 0});
  CHECK(study_page({t, a, {}, {}, {}}).find("arm1 is better") != std::string::npos);
}

TEST_CASE(
    "Stops of either scheme alike tell nothing, and a test with stops is the same when the two change "
    "places") {
  StudyTable t = made({0.0, 0.0}, 20, 1.0, 4, 1);
  for (std::size_t s = 0; s < 5; ++s) t.runs[s].finished = t.runs[20 + 5 + s].finished = false;
  const StudyAnalysis a = analyse(t);
  CHECK(says(a, "not distinguishable"));
  StudyTable turned = t;
  std::rotate(turned.runs.begin(), turned.runs.begin() + 20, turned.runs.end());
  const StudyAnalysis b = analyse(turned);
  CHECK(a.primary(0, 1).values.p == b.primary(0, 1).values.p);
  CHECK(a.primary(0, 1).lead == -b.primary(0, 1).lead);
  CHECK(a.primary(0, 1).values.a_below_b == Approx(1.0 - b.primary(0, 1).values.a_below_b));
}

TEST_CASE("An arm that never finished is behind all others, and with none left there is nothing to compare") {
  StudyTable t = made({0.0, 1.0}, 10, 0.1);
  for (std::size_t n = 0; n < 20; ++n) t.runs[n] = {false, "error", "no", {NAN, NAN}};
  const StudyAnalysis half = analyse(t);
  CAPTURE(half.answer);
  CHECK(half.ranking == std::vector<std::size_t>{1, 0});
  CHECK(half.primary(0, 1).values.p == smallest_p(10));
  CHECK(says(half, "arm1 is better"));
  CHECK(says(half, "arm0: all 20 prints stopped"));
  CHECK_FALSE(says(half, "nan"));
  for (auto& r : t.runs) r.finished = false;
  const StudyAnalysis none = analyse(t);
  CHECK(none.ranking.empty());
  CHECK(says(none, "nothing can be compared"));
  CHECK(!study_page({t, none, {}, {}, {}}).empty());
  StudyTable one = made({0.0, 1.0}, 1, 0.1);
  one.runs[0].finished = false;
  CHECK(says(analyse(one), "not distinguishable"));
  CHECK_FALSE(says(analyse(one), "nan"));
}

TEST_CASE("too few seeds to tell anything are told as such") {
  const StudyAnalysis a = analyse(made({5.0, 0.0}, 4, 0.1));
  CHECK(says(a, "not distinguishable"));
  REQUIRE(a.notes.size() == 1);
  CHECK(a.notes[0].find("4 seeds cannot tell 1 pair apart") != std::string::npos);
  CHECK(analyse(made({5.0, 0.0}, 6, 0.1)).notes.empty());
  const StudyAnalysis one = analyse(made({5.0, 0.0}, 1, 0.1));
  CHECK(says(one, "1 seed)"));
  CHECK(!says(one, "nan"));
  CHECK(analyse(made({5.0}, 6, 0.1)).notes.empty());
}

TEST_CASE("page and CSV hold every arm, escape what names hold, and are the same bytes each time") {
  StudyTable t = made({1.0, 0.0}, 8, 0.2);
  t.arms[0] = "a <b>\"c\"";
  t.runs[3].reason = "said \"no\", twice";
  const StudyAnalysis a = analyse(t);
  const StudyPage page{t, a, {{"control.scheme", "", {"mpc", "smf"}}}, {}, {{"build", "x"}}};
  const std::string html = study_page(page);
  CHECK(html.find("a &lt;b&gt;") != std::string::npos);
  CHECK(html.find("<b>\"c\"") == std::string::npos);
  CHECK(html.find("control.scheme") != std::string::npos);
  CHECK(html.find("http://www.w3.org/2000/svg") != std::string::npos);
  CHECK(html.find("src=") == std::string::npos);
  CHECK(html == study_page(page));
  const std::string csv = study_csv(t);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 32);
  CHECK(csv.find("\"a <b>\"\"c\"\"\"") != std::string::npos);
  CHECK(csv.find("\"said \"\"no\"\", twice\"") != std::string::npos);
}

TEST_CASE("The page says what a seed fixes in its lab, and holds no pair of which one does not measure") {
  StudyTable t = made({2.0, 1.0, 0.0}, 8, 0.2, 1, 1);
  for (std::size_t seed = 0; seed < 8; ++seed) t.runs[seed].metrics[1] = NAN;
  const StudyAnalysis a = analyse(t);
  StudyPage page{t, a, {}, {}, {}};
  CHECK(study_page(page).find("the same seed. Blue") != std::string::npos);
  page.nature = "the wind";
  const std::string html = study_page(page);
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
  StudyTable t = made({0.0, 1.0}, 9, 0.3, 1, 1);
  CHECK(profile_rows(t).empty());
  CHECK(profile_text(t, {}).empty());
  CHECK(profile_section(t, {}).empty());
  t.profile = {"RMS against height", "height_mm", "rms_um"};
  for (std::size_t arm = 0; arm < 2; ++arm)
    for (std::size_t seed = 0; seed < 9; ++seed) {
      StudyRun& r = t.runs[arm * 9 + seed];
      r.profile = {{1.2, 10.0 * double(arm + 1) + double(seed)}, {2.4, 100.0}, {3.6, NAN}};
      if (arm == 1 && seed > 2) r.profile.resize(1);  // stopped
    }
  const std::vector<ProfileRow> rows = profile_rows(t);
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
  CHECK(profile_csv(t, rows).find("\"arm1\",\"part0\",2.4,3,100,100,100,100,100\n") != std::string::npos);
  CHECK(profile_text(t, rows).find("100.0 [100.0, 100.0] 100.0") != std::string::npos);
  CHECK(profile_section(t, rows).find("RMS against height") != std::string::npos);
}

TEST_CASE("Accuracy against time has a mark for each scheme that finished") {
  StudyTable t = made({0.0, 1.0, 2.0}, 9, 0.3, 1, 1);
  t.metrics[1] = {"time_h", "h", "time", 2};
  for (std::size_t seed = 0; seed < 9; ++seed) t.runs[18 + seed].finished = false;
  const std::string plot = trade_off_plot(t, analyse(t), 1, 0);
  CHECK(plot.find(">arm0<") != std::string::npos);
  CHECK(plot.find(">arm1<") != std::string::npos);
  CHECK(plot.find(">arm2<") == std::string::npos);
}
