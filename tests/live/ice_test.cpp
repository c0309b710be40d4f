// Live prints of the ice lab at ten times the speed of the clock: one to its end, and kill -9 of its
// processes one by one: robot, path_planner and scheduler, or a tenth of all, or all. FIRN_ICE_VICTIM names a
// single one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/live/live_checks.h"
#include "tests/support/long_cases.h"

using namespace firn;
using namespace firn::test;

namespace {

const std::vector<std::string> kVictims{
    "robot",          "path_planner", "scheduler",      "valve_a",  "valve_b", "laser_point", "heater",
    "surface_mapper", "controller",   "flow_estimator", "recorder", "safety",  "launcher"};

/// Indices into kVictims.
std::vector<std::size_t> victims() {
  const char* one = std::getenv("FIRN_ICE_VICTIM");
  if (!one) return long_cases(kVictims.size(), 2);
  const auto found = std::find(kVictims.begin(), kVictims.end(), one);
  REQUIRE(found != kVictims.end());
  return {std::size_t(found - kVictims.begin())};
}

}  // namespace

TEST_CASE("a live ice print at ten times the speed of the clock finishes and replays bit for bit") {
  if (skipped()) return;
  LiveRun run(tiny_ice(31));
  run.start(false);
  const int status = status_of(run);
  CHECK(status == 0);
  check_finished_run(run);
}

TEST_CASE("processes of a live ice print killed: safe within a second, named, resumed, replayed") {
  if (skipped()) return;
  for (const std::size_t n : victims()) {
    const std::uint64_t seed = 41 + n;
    kill_and_resume(tiny_ice(seed), kVictims[n], "robot", seed, 1'500'000,
                    7'500'000);  // from the first path on
  }
}
