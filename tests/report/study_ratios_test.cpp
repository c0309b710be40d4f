// Ratios between the schemes of a study, on tables whose truth is known.
#include "report/study/study_ratios.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/grid/random.h"
#include "report/study/study_page.h"

using namespace firn;
using namespace firn::report;

namespace {

/// Values are day * factor of the scheme on the part * chance.
StudyTable planted(const std::vector<std::vector<double>>& factors, std::size_t seeds, double chance = 0.1) {
  StudyTable t;
  t.name = "planted";
  t.metrics = {{"rms_um", "um", "RMS error", 2}, {"layers", "", "layers", 1}, {"print_s", "s", "time", 0}};
  for (std::size_t a = 0; a < factors.size(); ++a) t.arms.push_back("scheme " + std::to_string(a));
  for (std::size_t p = 0; p < factors[0].size(); ++p) t.parts.push_back("world " + std::to_string(p));
  for (std::size_t s = 0; s < seeds; ++s) t.seeds.push_back(s + 1);
  t.baseline = "scheme 0";
  RandomStream random(7, Purpose::kTest);
  std::vector<double> day(seeds);
  for (double& d : day) d = std::exp(random.normal());
  for (std::size_t a = 0; a < factors.size(); ++a)
    for (std::size_t p = 0; p < factors[0].size(); ++p)
      for (std::size_t s = 0; s < seeds; ++s)
        t.runs.push_back(
            {true,
             "finished",
             "",
             {day[s] * factors[a][p] * std::exp(chance * random.normal()), 50.0 + double(a), 9.0}});
  return t;
}

const PartRatio& of(const StudyRatios& r, std::size_t arm, std::size_t part) {
  for (const PartRatio& p : r.parts)
    if (p.arm == arm && p.part == part) return p;
  throw std::out_of_range("no such ratio");
}

}  // namespace

TEST_CASE("A study without a baseline has no ratios") {
  StudyTable t = planted({{1.0}, {0.5}}, 10);
  t.baseline = "";
  CHECK_FALSE(study_ratios(t));
}

TEST_CASE("A metric that can be 0 has no ratios") {
  StudyTable t = planted({{1.0}, {0.5}}, 10);
  t.runs[3].metrics[0] = 0.0;
  CHECK_FALSE(study_ratios(t));
}

TEST_CASE("Planted ratios are found on each part, within their intervals") {
  const StudyRatios r = *study_ratios(planted({{1.0, 1.0}, {0.7, 1.3}}, 60));
  CHECK(of(r, 1, 0).values.interval.low < 0.7);
  CHECK(of(r, 1, 0).values.interval.high > 0.7);
  CHECK(of(r, 1, 1).values.ratio == Approx(1.3).epsilon(0.06));
}

TEST_CASE("The ratio over all parts is the geometric mean over the parts") {
  const StudyRatios r = *study_ratios(planted({{1.0, 1.0}, {0.5, 2.0}}, 40, 1e-6));
  CHECK(r.overall.front().ratio == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("A print without a value leaves its pair out, and counts in no profile") {
  StudyTable t = planted({{1.0}, {0.5}}, 10, 1e-6);
  t.runs[10].finished = false;  // of scheme 1
  const StudyRatios r = *study_ratios(t);
  CHECK(r.overall.front().left_out == 1);
  CHECK(of(r, 1, 0).values.pairs == 9);
  CHECK(r.profiles[1].share.back() == Approx(0.9));
}

TEST_CASE("A performance profile rises from the share of best prints to 1") {
  const StudyRatios r = *study_ratios(planted({{1.0, 1.0}, {0.5, 1.2}}, 20, 1e-6));
  CHECK(r.profiles[1].share.front() == Approx(0.5));
  CHECK(r.profiles[0].share.back() == Approx(1.0));
  for (const PerformanceProfile& p : r.profiles)
    for (std::size_t n = 1; n < p.share.size(); ++n) CHECK(p.share[n] >= p.share[n - 1]);
}

TEST_CASE("A scheme that no other betters in all metrics is said to be bettered by none") {
  const StudyRatios r = *study_ratios(planted({{1.0}, {0.5}, {1.5}}, 20, 1e-6));
  CHECK_FALSE(r.pareto[0].bettered_by);  // fewest layers
  CHECK_FALSE(r.pareto[1].bettered_by);  // least error
  CHECK(r.pareto[2].bettered_by == std::size_t{0});
}

TEST_CASE("A judged scheme that equals the best one on every part holds") {
  StudyTable t = planted({{1.0, 1.0}, {0.5, 1.2}, {0.5, 1.0}}, 80);
  t.judged = "scheme 2";
  const StudyRatios r = *study_ratios(t);
  CHECK(r.judged_holds());
  CHECK(r.judged_parts[0].best[0] == 1);
  CHECK(r.judged_parts[1].best[0] == 0);
}

TEST_CASE("A judged scheme that is behind on one part does not hold") {
  StudyTable t = planted({{1.0, 1.0}, {0.5, 1.2}, {0.5, 1.15}}, 80);
  t.judged = "scheme 2";
  const StudyRatios r = *study_ratios(t);
  CHECK(r.judged_parts[0].holds);
  CHECK_FALSE(r.judged_parts[1].holds);
  CHECK_FALSE(r.judged_holds());
}

TEST_CASE("With few seeds a judged scheme that equals the best one is not shown to") {
  StudyTable t = planted({{1.0}, {1.0}}, 4, 0.4);
  t.judged = "scheme 1";
  CHECK_FALSE(study_ratios(t)->judged_holds());
}

TEST_CASE("The best other scheme is chosen on seeds that do not count in the ratio") {
  // Scheme 1 is best in the first, third, ... seeds and scheme 2 in the others.
  StudyTable t = planted({{1.0}, {1.0}, {1.0}, {1.0}}, 40, 1e-6);
  for (std::size_t s = 0; s < 40; ++s) t.runs[(s % 2 == 0 ? 1 : 2) * 40 + s].metrics[0] *= 0.5;
  t.judged = "scheme 3";
  CHECK(study_ratios(t)->judged_parts[0].values.ratio == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("The page shows the ratios, the profile and the verdict on the judged scheme") {
  StudyTable t = planted({{1.0, 1.0}, {0.5, 0.5}, {0.5, 0.5}}, 30, 0.02);
  t.judged = "scheme 2";
  const StudyAnalysis a = analyse(t);
  const std::string page = study_page({t, a, {}, {}, {}});
  CHECK_THAT(page,
             Catch::Contains("Ratios to scheme 0") && Catch::Contains("Performance profiles") &&
                 Catch::Contains("scheme 2 is at most 10 % behind the best other scheme on 2 of 2 parts"));
}

TEST_CASE("The text shows a ratio with its interval for every part") {
  const StudyTable t = planted({{1.0, 1.0}, {0.5, 0.7}}, 30, 0.02);
  const std::string text = ratios_text(t, *study_ratios(t));
  CHECK_THAT(text, Catch::Contains("0.50 [") && Catch::Contains("0.70 ["));
}
