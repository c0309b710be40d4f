// Runs of the aerosol lab with a folder: replay, audit, report, death and resume, faults.
#include <catch2/catch.hpp>
#include <filesystem>

#include "cli/audit_command.h"
#include "cli/replay_command.h"
#include "config/include.h"
#include "core/grid/random.h"
#include "print/folder/run_report.h"
#include "print/labs/print_labs.h"
#include "print/simulated/lab_run.h"
#include "replay/print_verdict.h"
#include "report/run/report_data.h"
#include "report/run/report_page.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using firn::test::Scratch;

namespace {

/// Two short lines in few layers.
struct ShortLines {
  Scratch scratch{"lines"};
  Experiment experiment;
  RunFolder run;

  explicit ShortLines(std::vector<std::string> more = {})
      : experiment(load(std::move(more))),
        run(RunFolder::create(scratch / "runs", experiment, make_inputs(experiment, kLineFolder), {"test"})) {
  }

  static inline const std::filesystem::path kLineFolder =
      std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

  static Experiment load(std::vector<std::string> more) {
    std::vector<std::string> set{"aerosol.job=aerosol-lines.json", "aerosol.layers=3", "grid.nx=250",
                                 "grid.ny=80"};
    set.insert(set.end(), more.begin(), more.end());
    return load_experiment(kLineFolder / "aerosol-meander.toml", set);
  }

  LabRunReport go(const std::vector<std::string>& faults = {}, bool resume = false,
                  std::uint64_t crash_after = 0) {
    LabRunOptions o;
    o.resume = resume;
    o.crash_after_steps = crash_after;
    o.faults = parse_lab_faults(faults, experiment);
    return run_in_lab(run, o);
  }
  void check_replay() const {
    ReplayCommandOptions r;
    r.run = run.path().string();
    const replay::RunVerdict verdict = replay_verdict(r);
    INFO(replay::to_text(verdict));
    CHECK(verdict.identical());
  }
  replay::AuditVerdict check_audit() const {
    const replay::AuditVerdict audit = audit_verdict(run.path());
    INFO(replay::to_text(audit));
    CHECK(audit.clean());
    return audit;
  }
};

}  // namespace

TEST_CASE("A print of lines replays bit for bit, passes the audit and has a report of its lines", "[line]") {
  ShortLines lines;
  const LabRunReport report = lines.go();
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK(report.result.layers == 3);
  lines.check_replay();
  const replay::AuditVerdict audit = lines.check_audit();
  CHECK(audit.finished);
  CHECK(audit.commanded == 3 * 4);
  CHECK(audit.fired == audit.commanded);
  const replay::RunData data = run_data(lines.run.path());
  CHECK(data.layers.size() == 4);
  CHECK(data.layers.back().truth);
  const std::string page = replay::report_page({{data, "identical"}}, {});
  for (const char* section : {"Lines", "Cross-section", "close delay"})
    CHECK(page.find(section) != std::string::npos);
}

TEST_CASE(
    "A print of lines that dies at any step and resumes is finished, identical, and no way is run twice",
    "[line][seeded]") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    ShortLines lines;
    RandomStream random(seed, Purpose::kKill);
    LabRunReport report = lines.go({}, false, 1 + random.below(12'000));
    for (int n = 1; report.crashed || report.result.status == 3; ++n) {
      REQUIRE(n < 6);
      report = lines.go({}, true, n < 2 ? 1 + random.below(12'000) : 0);
    }
    INFO(report.result.reason);
    CHECK(report.result.status == 0);
    CHECK(report.result.layers == 3);
    lines.check_replay();
    lines.check_audit();
  }
}

TEST_CASE("A shutter that stays closed stops the print at the next map, by name", "[line][I12]") {
  ShortLines lines;
  const LabRunReport stopped = lines.go({"1 stage trip 7"});
  CHECK(stopped.result.status == 3);
  CHECK_THAT(stopped.result.reason, Catch::Contains("shutter stays closed"));
  lines.check_audit();
}
