// Live prints of the ice lab at ten times the speed of the clock: one to its end, and kill -9 of its
// processes one by one: robot, path_planner and scheduler, with FIRN_FULL every one of them. FIRN_ICE_VICTIM
// names a single one.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

std::vector<std::string> victims() {
  if (const char* one = std::getenv("FIRN_ICE_VICTIM")) return {one};
  std::vector<std::string> names{"robot", "path_planner", "scheduler"};
  if (std::getenv("FIRN_FULL"))
    for (const char* name : {"valve_a", "valve_b", "laser_point", "heater", "surface_mapper", "controller",
                             "flow_estimator", "recorder", "safety", "launcher"})
      names.push_back(name);
  return names;
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
  std::uint64_t seed = 40;
  for (const std::string& victim : victims()) {
    ++seed;
    kill_and_resume(tiny_ice(seed), victim, "robot", seed, 1'500'000, 7'500'000);  // from the first path on
  }
}
