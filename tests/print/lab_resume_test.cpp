// Prints that die again and again at any step and are resumed: in simulated time, so that many fit into a
// second.
#include <catch2/catch.hpp>

#include <unistd.h>

#include <filesystem>

#include "cli/replay_command.h"
#include "core/grid/random.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_record.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "tests/support/long_cases.h"
#include "tests/support/tiny_print.h"
#include "tests/support/watched_jet.h"

namespace firn {
namespace {

using test::long_cases;

Experiment tiny(const std::string& scheme, std::uint64_t seed) {
  Experiment e = test::tiny_print("resume", scheme);
  e.plant.seed = seed;
  return e;
}

struct TemporaryRuns {
  TemporaryRuns()
      : root(std::filesystem::temp_directory_path() / ("firn-resume-" + std::to_string(getpid()))) {}
  ~TemporaryRuns() { std::filesystem::remove_all(root); }
  std::filesystem::path root;
};

struct Story {
  int crashes = 0;
  LabRunReport report;
  std::filesystem::path path;
};

Story print_with_crashes(const std::filesystem::path& root, const Experiment& e, std::uint64_t seed,
                         int max_crashes) {
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  RandomStream random(seed, Purpose::kKill);
  Story s;
  s.path = run.path();
  LabRunOptions o;
  for (int n = 0;; ++n) {
    o.resume = n > 0;
    if (n > 0) o.orders = {{new_order_id(), OperatorVerb::kAcceptDoubt, {}, {}}};
    o.crash_after_steps = n < max_crashes ? 1 + random.below(2500) : 0;
    s.report = run_in_lab(full_product(), run, o);
    if (!s.report.crashed) return s;
    ++s.crashes;
  }
}

TEST_CASE("a print that dies at any step and resumes is finished, replays identical and passes the audit") {
  const TemporaryRuns runs;
  const std::vector<std::size_t> cases = long_cases(300, 15);
  int crashes = 0;
  for (const std::size_t n : cases) {
    const std::uint64_t seed = n + 1;
    const char* scheme = seed % 3 == 0 ? "open_loop" : seed % 3 == 1 ? "mpc" : "smf";
    CAPTURE(seed, scheme);
    Experiment e = tiny(scheme, seed);
    if (seed % 2 == 0)
      e.estimator.droplets = e.control.adapt_model = "on";  // the learned model goes on as well
    const Story s = print_with_crashes(runs.root, e, seed, 4);
    crashes += s.crashes;
    INFO(s.report.result.reason);
    REQUIRE(s.report.result.status == 0);

    ReplayCommandOptions r;
    r.run = s.path.string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    REQUIRE(verdict.identical());

    const replay::AuditVerdict audit = replay::audit_run(s.path);
    if (!audit.violations.empty()) INFO(audit.violations.front().what);
    CAPTURE(s.path.string());
    REQUIRE(audit.violations_total == 0);
    for (const replay::Unknown& u : audit.unknowns) REQUIRE(u.resolved_by.has_value());
  }
  REQUIRE(crashes > int(2 * cases.size()));
}

TEST_CASE(
    "a print of two inks in four sub-patterns dies at any step, resumes, replays identical and passes the "
    "audit") {
  const TemporaryRuns runs;
  const std::vector<std::size_t> cases = long_cases(100, 6);
  int crashes = 0;
  for (const std::size_t n : cases) {
    const std::uint64_t seed = n + 1;
    Experiment e = tiny("mpc", seed);
    e.part.shape.height_mm = 0.015;
    e.geometry.solid.kind = "pipe";
    e.geometry.solid.outer_diameter_mm = 1.4;
    e.geometry.solid.inner_diameter_mm = 0.6;
    e.process.sub_patterns = seed % 3 == 0 ? 1 : seed % 3 == 1 ? 4 : 2;
    e.plant.nozzle_b_x_mm = 20.03;
    e.plant.model = seed % 2 ? "droplets" : "lu2015";
    CAPTURE(seed, e.process.sub_patterns, e.plant.model);
    const Story s = print_with_crashes(runs.root, e, seed, 4);
    crashes += s.crashes;
    INFO(s.report.result.reason);
    REQUIRE(s.report.result.status == 0);
    ReplayCommandOptions r;
    r.run = s.path.string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    REQUIRE(verdict.identical());
    REQUIRE(verdict.nodes.size() == taking_part(full_product(), e).size());
    const replay::AuditVerdict audit = replay::audit_run(s.path);
    if (!audit.violations.empty()) INFO(audit.violations.front().what);
    REQUIRE(audit.violations_total == 0);
    for (const replay::Unknown& u : audit.unknowns) REQUIRE(u.resolved_by.has_value());
  }
  CHECK(crashes > int(2 * cases.size()));
}

TEST_CASE(
    "a print with droplets beside centres dies at any step, resumes, replays identical and passes the "
    "audit") {
  const TemporaryRuns runs;
  const std::vector<std::size_t> cases = long_cases(200, 10);
  int crashes = 0;
  std::int64_t beside = 0;
  for (const std::size_t n : cases) {
    const std::uint64_t seed = n + 1;
    Experiment e = tiny("pattern", seed);
    e.control.pattern.seed = seed;
    e.actuation.offsets = seed % 3 ? OffsetKind::kGrid : OffsetKind::kX;
    e.actuation.positions_x = 1 + int(seed % 8);
    e.actuation.positions_y = 1 + int(seed % 5);
    if (seed % 2) {  // so slow a jet that rows of near droplets take two runs
      e.jet.max_rate_hz = 30;
      e.process.pass_speed_mm_s = 7.0;
    }
    if (seed % 4 == 0) test::watch_jet(e);
    CAPTURE(seed);
    const Story s = print_with_crashes(runs.root, e, seed, 4);
    crashes += s.crashes;
    INFO(s.report.result.reason);
    REQUIRE(s.report.result.status == 0);
    ReplayCommandOptions r;
    r.run = s.path.string();
    const replay::RunVerdict verdict = replay_verdict(full_product(), r);
    INFO(replay::to_text(verdict));
    REQUIRE(verdict.identical());
    const replay::AuditVerdict audit = replay::audit_run(s.path);
    if (!audit.violations.empty()) INFO(audit.violations.front().what);
    CAPTURE(s.path.string());
    REQUIRE(audit.violations_total == 0);
    REQUIRE(audit.fired > 0);
    REQUIRE(audit.ignored == 0);
    for (const replay::Unknown& u : audit.unknowns) REQUIRE(u.resolved_by.has_value());
    for (const replay::PassOrder& o : replay::read_audit_record(s.path, OffsetTable(e.actuation)).orders)
      for (const std::uint32_t c : o.cells) beside += o.placement.map.of(c) != 0;
  }
  CHECK(crashes > int(2 * cases.size()));
  CHECK(beside > 20 * std::int64_t(cases.size()));
}

TEST_CASE("the same experiment and seed give the same bytes in every write-ahead file but for identity") {
  const TemporaryRuns runs;
  const Experiment e = tiny("mpc", 7);
  std::vector<std::vector<double>> surfaces;
  std::vector<std::uint64_t> steps;
  for (int n = 0; n < 2; ++n) {
    const runs::RunFolder run =
        runs::RunFolder::create(runs.root, e, make_inputs(full_product(), e, ""), {"test"});
    const LabRunReport r = run_in_lab(full_product(), run, {});
    surfaces.push_back(r.truth.cells);
    steps.push_back(r.steps);
  }
  REQUIRE(surfaces[0] == surfaces[1]);
  REQUIRE(steps[0] == steps[1]);
}

}  // namespace
}  // namespace firn
