// kill -9 of each process of a live print at a random moment.
#include <unistd.h>

#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

void kill_and_resume(const std::string& victim, std::uint64_t seed, bool two_inks = false) {
  if (skipped()) return;
  RandomStream random(seed, Purpose::kKill);
  LiveRun run(two_inks ? tiny_part_of_two_inks(seed) : tiny_part(seed));
  run.start(false);
  INFO(victim << ", seed " << seed << ", " << run.path());
  REQUIRE(run.wait_started());
  ::usleep(useconds_t(random.below(1'800'000)));
  REQUIRE(run.running());
  const std::int64_t at = run.kill(victim);
  const int status = run.wait();
  run.wait_all_gone();
  INFO(run.said());
  CHECK(status == (victim == "launcher" ? -1 : 3));
  CHECK_FALSE(run.folder().result());
  check_safe_after(run, at);
  if (victim != "launcher") CHECK_THAT(run.said(), Catch::Contains(victim + " was killed by signal 9"));
  else CHECK(local_stop_cause(run, "stage") == "the launcher is gone");

  run.start(true);
  const int resumed = run.wait();
  INFO(run.said());
  CHECK(resumed == 0);
  check_finished_run(run);
}

}  // namespace

TEST_CASE("scheduler killed: safe, named, resumed, replayed") { kill_and_resume("scheduler", 11); }
TEST_CASE("surface mapper killed: safe, named, resumed, replayed") { kill_and_resume("surface_mapper", 12); }
TEST_CASE("controller killed: safe, named, resumed, replayed") { kill_and_resume("controller", 13); }
TEST_CASE("stage driver killed: safe, named, resumed, replayed") { kill_and_resume("stage", 14); }
TEST_CASE("jet driver killed: safe, named, resumed, replayed") { kill_and_resume("jet", 15); }
TEST_CASE("laser profiler driver killed: safe, named, resumed, replayed") { kill_and_resume("laser_profiler", 16); }
TEST_CASE("lamp driver killed: safe, named, resumed, replayed") { kill_and_resume("lamp", 17); }
TEST_CASE("recorder killed: safe, named, resumed, replayed") { kill_and_resume("recorder", 18); }
TEST_CASE("safety killed: safe, named, resumed, replayed") { kill_and_resume("safety", 19); }
TEST_CASE("driver of the second jet killed: safe, named, resumed, replayed") { kill_and_resume("jet_b", 21, true); }
TEST_CASE("launcher killed: every process stops by itself, resumed, replayed") { kill_and_resume("launcher", 20); }
