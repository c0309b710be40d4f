#include <catch2/catch.hpp>
#include <filesystem>

#include "studies/compare/study_runner.h"

using namespace firn;

TEST_CASE("Every scheme of the README's cylinder prints it to its end") {
  const std::filesystem::path folder = FIRN_SOURCE_DIR "/experiments/studies";
  const StudyPlan plan =
      plan_study(load_study(folder / "cylinder.toml"), folder, inkjet_study_lab(), "cylinder.toml");
  REQUIRE(plan.experiments.size() == 12);
  for (std::size_t n = 0; n < plan.experiments.size(); ++n) {
    Experiment e = plan.experiments[n];
    plan.lab->set_seed(e, 1);
    const StudyPrint print = plan.lab->print(e, *plan.inputs[n], plan.edge_bound);
    CAPTURE(plan.study.arms[n / plan.study.parts.size()].name, print.reason);
    CHECK(print.outcome == "finished");
  }
}
