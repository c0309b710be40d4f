// Settings of a study's design beside its result, as parallel coordinates.
#include "report/study/settings_plot.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/grid/random.h"

using namespace firn;
using namespace firn::report;
using Catch::Contains;

namespace {

// Schemes of a design: the metric is the distance of kp from 2, and ki says nothing.
struct Design {
  StudyTable table;
  StudyAnalysis analysis;
  std::vector<DifferingParameter> settings{{"control.smf.kp", "", {}}, {"control.smf.ki_star", "", {}}};
};

Design design_of(std::size_t arms, std::uint64_t key) {
  Design d;
  d.table.metrics = {{"rms_um", "um", "RMS error", 2}};
  d.table.parts = {"part"};
  RandomStream random(key, Purpose::kTest);
  for (std::size_t arm = 0; arm < arms; ++arm) {
    const double kp = random.uniform(0.2, 4.0);
    d.table.arms.push_back("arm <" + std::to_string(arm) + ">");
    d.settings[0].values.push_back(std::to_string(kp));
    d.settings[1].values.push_back(std::to_string(random.uniform(0.001, 1.0)));
    ArmSummary s;
    s.arm = arm;
    s.seeds = 3;
    s.mean = 1.0 + std::abs(kp - 2.0);
    d.analysis.summaries.push_back(s);
  }
  return d;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(word, at)) != text.npos; at += word.size()) ++n;
  return n;
}

std::string plot_of(const Design& d) { return settings_plot(d.table, d.analysis, d.settings); }

}  // namespace

TEST_CASE("Each scheme of a design is a line over its settings and its result, the best quarter in colour") {
  for (const std::size_t arms : {4u, 9u, 32u}) {
    const std::string svg = plot_of(design_of(arms, arms));
    CHECK(count(svg, "<title>") == arms + 1);  // and the drawing's
    CHECK(count(svg, "stroke=\"var(--c0)\"") == (arms + 3) / 4);
    CHECK_THAT(svg, Contains(">kp<") && Contains(">ki_star<") && Contains(">rms_um [um]<"));
    CHECK_THAT(svg, !Contains("arm <"));  // a scheme's name is text
  }
}

TEST_CASE("A scheme without a result is left out of the picture of settings") {
  Design d = design_of(9, 1);
  d.analysis.summaries[4].seeds = 0;
  CHECK(count(plot_of(d), "<title>") == 9);
  CHECK_THAT(plot_of(d), !Contains("arm &lt;4&gt;"));
}

TEST_CASE(
    "Settings that are words, or have two values, are no axis, and without an axis there is no picture") {
  Design d = design_of(9, 2);
  d.settings[1].values[3] = "\"greedy\"";
  CHECK_THAT(plot_of(d), Contains(">kp<") && !Contains("ki_star"));
  for (std::size_t n = 0; n < 9; ++n) d.settings[0].values[n] = n % 2 ? "1" : "2";
  CHECK(plot_of(d).empty());
  CHECK(plot_of(design_of(3, 1)).empty());
  d.settings.clear();
  CHECK(plot_of(d).empty());
}
