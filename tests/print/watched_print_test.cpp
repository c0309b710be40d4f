// Prints that watch their jet with the camera, in simulated time: where droplets land, the gate, crashes.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "cli/replay_command.h"
#include "core/grid/random.h"
#include "firn/droplet_sweep_t.hpp"
#include "plant/record/record.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "runs/read/run_reader.h"
#include "tests/support/long_cases.h"
#include "tests/support/tiny_print.h"
#include "tests/support/watched_jet.h"

namespace firn {
namespace {

struct WatchedRuns {
  WatchedRuns()
      : root(std::filesystem::temp_directory_path() / ("firn-watched-" + std::to_string(getpid()))) {}
  ~WatchedRuns() { std::filesystem::remove_all(root); }
  std::filesystem::path root;
};

Experiment watched_print(std::uint64_t seed) {
  Experiment e = test::tiny_print("watched");
  test::watch_jet(e);
  e.plant.seed = seed;
  return e;
}

void check_identical_and_clean(const Experiment& e, const std::filesystem::path& run) {
  ReplayCommandOptions r;
  r.run = run.string();
  const replay::RunVerdict verdict = replay_verdict(full_product(), r);
  INFO(replay::to_text(verdict));
  CHECK(verdict.identical());
  CHECK(verdict.nodes.size() == taking_part(full_product(), e).size());
  const replay::AuditVerdict audit = replay::audit_run(run);
  if (!audit.violations.empty()) INFO(audit.violations.front().what);
  CHECK(audit.violations_total == 0);
}

std::vector<droplet_sweep_t> sweeps_of(const std::filesystem::path& run) {
  std::vector<droplet_sweep_t> sweeps;
  runs::RunReader(run).each<droplet_sweep_t>(channels::kDropletSweep.name,
                                             [&](const droplet_sweep_t& m) { sweeps.push_back(m); });
  return sweeps;
}

/// Farthest landing from the middle of its cell along the rows [um].
double worst_landing_um(const runs::RunFolder& run, const GridSpec& grid) {
  double worst_um = 0.0;
  for (const plant::ShotRecord& s : plant::read_history(run.world_record_path()).shots)
    worst_um = std::max(worst_um, 1e3 * std::abs(s.landed_x_mm - grid.x_mm(s.i)));
  return worst_um;
}

}  // namespace

TEST_CASE("Droplets of a print land within 3 um of their cells by the camera's lead, and not without it") {
  const double speed_m_s = GENERATE(1.2, 2.0, 4.0);
  const bool placement = GENERATE(true, false);
  const WatchedRuns runs;
  Experiment e = watched_print(1);
  e.watch.gate = OnOff::kOff;
  e.watch.placement = placement ? OnOff::kOn : OnOff::kOff;
  e.watch.step_us = 60.0 / speed_m_s;
  e.plant.camera.height_px = 280;
  e.plant.camera.drop_speed_m_s = speed_m_s;
  e.plant.placement_std_mm = 0.0;
  const runs::RunFolder run =
      runs::RunFolder::create(runs.root, e, make_inputs(full_product(), e, ""), {"test"});
  const LabRunReport report = run_in_lab(full_product(), run, {});
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK((worst_landing_um(run, e.grid) <= 3.0) == placement);
  check_identical_and_clean(e, run.path());
}

TEST_CASE("A watched print purges a jet that is dead at first, then sees it before every layer") {
  const WatchedRuns runs;
  Experiment e = watched_print(2);
  e.plant.camera.dead_before = 1;
  const runs::RunFolder run =
      runs::RunFolder::create(runs.root, e, make_inputs(full_product(), e, ""), {"test"});
  const LabRunReport report = run_in_lab(full_product(), run, {});
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  const auto sweeps = sweeps_of(run.path());
  REQUIRE(int(sweeps.size()) == report.result.layers + 1);
  CHECK(sweeps[0].with_droplet == 0);
  for (std::size_t n = 1; n < sweeps.size(); ++n) CHECK(sweeps[n].used == e.watch.frames);
}

TEST_CASE("A jet that stays dead stops a print before its first droplet, and a resume sees it again") {
  const WatchedRuns runs;
  Experiment e = watched_print(3);
  e.plant.camera.dead_before = 3;
  const runs::RunFolder run =
      runs::RunFolder::create(runs.root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunReport report = run_in_lab(full_product(), run, {});
  CHECK(report.result.status == 3);
  CHECK_THAT(report.result.reason, Catch::Contains("the nozzle is dead or clogged"));
  CHECK(plant::read_history(run.world_record_path()).shots.empty());
  LabRunOptions again;
  again.resume = true;
  report = run_in_lab(full_product(), run, again);
  INFO(report.result.reason);
  CHECK(report.result.status == 0);
  check_identical_and_clean(e, run.path());
}

TEST_CASE("A watched print that dies at any step and resumes is finished, identical and clean") {
  const WatchedRuns runs;
  int crashes = 0;
  const std::vector<std::size_t> cases = test::long_cases(100, 6);
  for (const std::size_t n : cases) {
    const std::uint64_t seed = n + 1;
    CAPTURE(seed);
    const Experiment e = watched_print(seed);
    const runs::RunFolder run =
        runs::RunFolder::create(runs.root, e, make_inputs(full_product(), e, ""), {"test"});
    RandomStream random(seed, Purpose::kKill);
    LabRunReport report;
    for (int k = 0; k == 0 || report.crashed; ++k) {
      LabRunOptions o;
      o.resume = k > 0;
      if (k > 0) o.orders = {{new_order_id(), OperatorVerb::kAcceptDoubt, {}, {}}};
      o.crash_after_steps = k < 4 ? 1 + random.below(2500) : 0;
      report = run_in_lab(full_product(), run, o);
      crashes += report.crashed;
    }
    INFO(report.result.reason);
    REQUIRE(report.result.status == 0);
    check_identical_and_clean(e, run.path());
  }
  CHECK(crashes > int(2 * cases.size()));
}

}  // namespace firn
