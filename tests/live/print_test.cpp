#include <catch2/catch.hpp>

#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

TEST_CASE("a live print of small processes finishes, leaves a whole log, and replays") {
  if (skipped()) return;
  LiveRun run(tiny_part(1));
  run.start(false);
  INFO(run.path());
  REQUIRE(run.wait_started());
  const int status = run.wait();
  INFO(run.said());
  CHECK(status == 0);
  const auto result = run.folder().result();
  REQUIRE(result);
  CHECK(result->outcome == "finished");
  CHECK(result->layers >= 3);
  check_finished_run(run);
}

TEST_CASE("Ctrl-C makes the lab safe, exits 130, and the print can be resumed") {
  if (skipped()) return;
  LiveRun run(tiny_part(2));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(700'000);
  const std::int64_t at = monotonic_ns();
  run.interrupt();
  CHECK(run.wait() == 130);
  run.wait_all_gone();
  CHECK_FALSE(run.folder().result());
  check_safe_after(run, at);
  CHECK_THAT(run.said(), Catch::Contains("interrupted by the operator"));
  run.start(true);
  const int status = run.wait();
  INFO(run.said());
  CHECK(status == 0);
  check_finished_run(run);
}
