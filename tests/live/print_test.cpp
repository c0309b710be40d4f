#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "core/grid/random.h"
#include "firn/height_model_t.hpp"
#include "runs/read/run_reader.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

TEST_CASE("a live print of small processes finishes, leaves a whole log, and replays") {
  if (skipped()) return;
  LiveRun run(tiny_part(1));
  run.start(false);
  const int status = status_of(run);
  CHECK(status == 0);
  const auto result = run.folder().result();
  REQUIRE(result);
  CHECK(result->outcome == "finished");
  CHECK(result->layers >= 3);
  check_finished_run(run);
}

TEST_CASE(
    "a live print of two inks in four sub-patterns finishes, replays, and the audit knows every droplet's "
    "ink") {
  if (skipped()) return;
  LiveRun run(tiny_part_of_two_inks(5));
  run.start(false);
  const int status = status_of(run);
  CHECK(status == 0);
  check_finished_run(run);
}

TEST_CASE("a live print whose heights come from a point laser that the stage moves finishes, and replays") {
  if (skipped()) return;
  Experiment e = tiny_part(6);
  e.part.shape.height_mm = 0.012;
  e.devices.kind["laser_profiler"] = "lkg";
  LiveRun run(e);
  run.start(false);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
}

TEST_CASE("a live print with droplet_estimator learns after every layer, and replays") {
  if (skipped()) return;
  Experiment e = tiny_part(4);
  e.estimator.droplets = e.control.adapt_model = "on";
  LiveRun run(e);
  run.start(false);
  const int status = status_of(run);
  CHECK(status == 0);
  check_finished_run(run);
  const auto result = run.folder().result();
  REQUIRE(result);
  int last =
      -1;  // a busy machine may make the profiler miss rows: the layer is measured, and told, once more
  runs::RunReader(run.path()).each<height_model_t>(channels::kHeightModel.name, [&](const height_model_t& m) {
    CHECK(m.layer >= last);
    CHECK(m.layer <= last + 1);
    CHECK(m.layers_used == m.layer);
    last = m.layer;
  });
  CHECK(last == result->layers);
}

TEST_CASE("a full disk stops the print by name, and a resume fills the log again") {
  if (skipped()) return;
  LiveRun run(tiny_part(3));
  // The recorder alone may write no file beyond 64 KiB, which is reported like a full disk.
  run.start(false, programs_with(run.path().parent_path() / "programs", "recorder",
                                 starts("recorder", "ulimit -f 128")));
  const int stopped = run.wait();
  run.wait_all_gone();
  INFO(run.said());
  CHECK(stopped == 3);
  CHECK_THAT(run.said(), Catch::Contains("recorder: cannot record") && Catch::Contains("log.lcm"));

  run.start(true);
  const int status = run.wait_finished();
  INFO(run.said());
  CHECK(status == 0);
  CHECK_THAT(run.said(), Catch::Contains("recording gap, repaired"));
  check_finished_run(run);
}

TEST_CASE("droplets that the stage triggers after a stop has disarmed the jet are never reported as done") {
  if (skipped()) return;
  RandomStream random(8, Purpose::kKill);
  LiveRun run(tiny_part(2));
  for (int tries = 0, status = 130; tries < 8 && status == 130; ++tries) {
    run.start(tries > 0);
    REQUIRE(run.wait_started());
    ::usleep(useconds_t(200'000 + random.below(400'000)));
    ::kill(run.pid_of("stage"), SIGSTOP);  // its controller goes on with the row
    run.interrupt();
    ::usleep(30'000);
    ::kill(run.pid_of("stage"), SIGCONT);
    status = run.wait();
    run.wait_all_gone();
  }
  run.start(true);
  const int status = run.wait_finished();
  INFO(run.said());
  CHECK(status == 0);
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
  const int status = run.wait_finished();
  INFO(run.said());
  CHECK(status == 0);
  check_finished_run(run);
}
