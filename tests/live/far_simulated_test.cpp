// Simulated instruments at truly other computers: the world is at the launcher's, and the line is their
// cable.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "plant/record/record.h"
#include "runs/folder/host_record.h"
#include "runtime/run_clock.h"
#include "tests/live/far_hosts.h"
#include "tests/live/live_checks.h"
#include "tests/live/no_hosts.h"
#include "tests/support/lateness.h"

using namespace firn;
using namespace firn::test;

namespace {

/// Stage and jet at the host "bench", profiler at "attic", the lamp here.
Experiment elsewhere(const FarHosts& hosts, std::uint64_t seed) {
  Experiment e = tiny_part(seed);
  e.run.time_scale = 1.0;
  for (const char* host : {"bench", "attic"})
    e.hosts.address[host] = std::string(host) + ":" + hosts.firn_elsewhere();
  e.hosts.of_node["stage"] = e.hosts.of_node["jet"] = "bench";
  e.hosts.of_node["laser_profiler"] = "attic";
  return e;
}

}  // namespace

TEST_CASE("simulated instruments at computers of their own print as beside the world, replay and are clean",
          "[hosts]") {
  if (no_hosts()) return;
  FarHosts hosts({"bench", "attic"});
  hosts.line("bench", 0.005, 0.001, 0.01);
  LiveRun run(elsewhere(hosts, 12));
  run.start(false);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
  CHECK(runs::incomplete_text(run.path()).empty());
  const auto port =
      hosts.folder() / "bench/firn/hosts/bench" / run.path().lexically_normal().filename() / "io/stage";
  CHECK(std::filesystem::exists(port.parent_path()));
  CHECK_FALSE(std::filesystem::is_symlink(port));  // to the world's socket, which is at the launcher's
}

// The stop's bytes do not arrive: the instruments are as safe as those of a computer that stands still.
TEST_CASE(
    "a simulated instrument whose line is cut stops as one whose cable is pulled, and the print resumes",
    "[hosts]") {
  if (no_hosts()) return;
  constexpr double kOwnWatchdog_s = 1.0;
  constexpr unsigned kIntoThePrint_us = 2'500'000;
  FarHosts hosts({"bench", "attic"});
  const Experiment e = elsewhere(hosts, 13);
  const Lateness lateness;
  LiveRun run(e);
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(kIntoThePrint_us);
  const std::int64_t at = monotonic_ns();
  hosts.cut("bench");
  const int status = run.wait();
  run.wait_all_gone();
  INFO(run.said());
  CHECK(status == 3);
  CHECK(unsafe_for_s(run, at) <= e.run.lease_s + kOwnWatchdog_s + lateness.longest_s());
  hosts.mend("bench");
  run.start(true);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
}
