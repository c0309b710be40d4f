#include "config/changes.h"

#include <catch2/catch.hpp>

namespace firn {
namespace {

TEST_CASE("only options that core marks may change while a print runs, within their limits") {
  Experiment e;
  CHECK(change_problem(e, "control.max_layers", "40").empty());
  CHECK(change_problem(e, "control.mpc.alpha", "0.5").empty());
  CHECK_THAT(change_problem(e, "control.max_layers", "-1"), Catch::Contains("control.max_layers = -1"));
  CHECK_THAT(change_problem(e, "control.max_layers", "many"), Catch::Contains("control.max_layers"));
  CHECK_THAT(change_problem(e, "grid.nx", "40"),
             Catch::Contains("grid.nx: cannot change") && Catch::Contains("control.max_layers"));
  CHECK_THAT(change_problem(e, "process.max_layers", "40"), Catch::Contains("unknown key"));
  CHECK_THAT(change_problem(e, "ice.saturated_share", "0.4"),
             Catch::Contains("cannot change"));  // of another lab
}

TEST_CASE("the target's offset may change where a scheme answers the measured surface, and nowhere else") {
  for (const std::string scheme : {"mpc", "smf", "threshold", "open_loop", "pattern"}) {
    Experiment e;
    e.control.scheme = scheme;
    const std::string problem = change_problem(e, "control.target_offset_mm", "-0.01");
    INFO(scheme << ": " << problem);
    if (scheme == "open_loop" || scheme == "pattern")
      CHECK_THAT(problem, Catch::Contains("control.target_offset_mm: is of schemes with feedback"));
    else
      CHECK(problem.empty());
  }
}

TEST_CASE("scheme auto takes changes of the schemes that it chooses among, and not of what it sets itself") {
  Experiment e;
  e.control.scheme = "auto";
  for (const char* key : {"control.smf.kp", "control.mpc.max_evaluations", "control.threshold.threshold_mm"})
    CHECK(change_problem(e, key, "1").empty());
  CHECK_THAT(change_problem(e, "control.smf.ki_star", "0.3"), Catch::Contains("is 0 in scheme auto"));
}

TEST_CASE("a change leaves all other values as they are, and a refused one leaves all") {
  Experiment e;
  e.control.smf.kp = 0.7;
  e.plant.seed = 9;
  Changes changes(e);
  REQUIRE(changes.set("control.max_layers", "7").empty());
  const auto differing = differences(e, changes.experiment());
  REQUIRE(differing.size() == 1);
  CHECK(differing[0].key == "control.max_layers");
  CHECK(changes.experiment().control.max_layers == 7);
  REQUIRE_FALSE(changes.set("control.max_layers", "0").empty());
  CHECK(changes.experiment().control.max_layers == 7);
}

TEST_CASE("a command is taken once, and a command without a number always") {
  Changes changes{Experiment{}};
  CHECK(changes.take(5));
  CHECK_FALSE(changes.take(5));
  CHECK(changes.take(0));
  CHECK(changes.take(0));
}

}  // namespace
}  // namespace firn
