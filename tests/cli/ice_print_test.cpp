#include <catch2/catch.hpp>

#include <filesystem>

#include "cli/audit_command.h"
#include "cli/ice_inputs.h"
#include "cli/lab_run.h"
#include "cli/memory_print.h"
#include "cli/replay_command.h"
#include "cli/targets.h"
#include "config/include.h"
#include "core/grid/random.h"
#include "replay/print_verdict.h"
#include "replay/report_data.h"
#include "replay/report_page.h"
#include "tests/logfile/scratch.h"

using namespace firn;

namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(FIRN_SOURCE_DIR) / "experiments";

struct Small {
  Experiment experiment;
  Blobs inputs;
};

Small small(const std::vector<std::string>& overrides) {
  Small s{load_experiment(kFolder / "ice-small.toml", overrides), {}};
  s.inputs = make_inputs(s.experiment, kFolder);
  place_ice_field(s.experiment, s.inputs);
  return s;
}

void check_record(const fs::path& run) {
  ReplayCommandOptions r;
  r.run = run.string();
  const replay::RunVerdict verdict = replay_verdict(r);
  INFO(replay::to_text(verdict));
  CHECK(verdict.identical());
  const replay::AuditVerdict audit = audit_verdict(run);
  INFO(replay::to_text(audit));
  CHECK(audit.clean());
  CHECK(audit.finished);
  CHECK(audit.fired == audit.commanded);
}

}  // namespace

TEST_CASE("A small ice print finishes in process, replays bit for bit, passes the audit and has a report") {
  const test::Scratch scratch("ice-print");
  const Small s = small({});
  const RunFolder run = RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
  const LabRunReport report = run_in_lab(run, {});
  INFO(report.result.reason);
  REQUIRE(report.result.status == 0);
  CHECK(report.result.layers == 15);
  check_record(run.path());

  const replay::RunData data = replay::read_run_data(run.path());
  REQUIRE(data.ice);
  CHECK(data.ice->intervals.size() == 3);
  REQUIRE(data.ice->field);
  REQUIRE(data.ice->curve);
  CHECK(data.layers.back().truth);
  const std::string page = replay::report_page({{data, "identical"}}, {});
  for (const char* section : {"Part as built", "Error per interval", "RMS deviation against height", "Along one path"})
    CHECK(page.find(section) != std::string::npos);
}

TEST_CASE("Feedback brings the true surface nearer to the nominal height than the open loop, whichever way the valves drift") {
  for (const char* drift : {"-0.2", "0.2"}) {
    const std::vector<std::string> off = {std::string("plant.ice.drift_water=") + drift, std::string("plant.ice.drift_sme=") + drift};
    double rms_mm[2];
    for (const bool feedback : {false, true}) {
      std::vector<std::string> overrides = off;
      overrides.push_back(feedback ? "control.scheme=smf" : "control.scheme=open_loop");
      const Small s = small(overrides);
      const MemoryPrintReport r = print_in_memory(s.experiment, s.inputs);
      INFO(r.result.reason);
      REQUIRE(r.result.status == 0);
      rms_mm[feedback] = r.error.rms_mm;
    }
    CAPTURE(drift);
    CHECK(rms_mm[1] < rms_mm[0]);
  }
}

TEST_CASE("An ice print that dies at any step and resumes is finished, replays identical and runs no path twice") {
  const test::Scratch scratch("ice-resume");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    const Small s = small({});
    const RunFolder run = RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
    RandomStream random(seed, Purpose::kKill);
    LabRunReport report;
    for (int n = 0; n == 0 || report.crashed; ++n) {
      LabRunOptions o;
      o.resume = n > 0;
      o.crash_after_steps = n < 2 ? 1 + random.below(60000) : 0;
      report = run_in_lab(run, o);
    }
    INFO(report.result.reason);
    REQUIRE(report.result.status == 0);
    ReplayCommandOptions r;
    r.run = run.path().string();
    CHECK(replay_verdict(r).identical());
    const replay::AuditVerdict audit = audit_verdict(run.path());
    INFO(replay::to_text(audit));
    CHECK(audit.clean());
  }
}

TEST_CASE("A tank that runs empty stops the whole print by name, and the record replays") {
  const test::Scratch scratch("ice-empty-tank");
  const Small s = small({"plant.ice.tank_water_mm3=300", "ice.max_saturated_intervals=2"});
  const RunFolder run = RunFolder::create(scratch / "runs", s.experiment, s.inputs, {"test"});
  const LabRunReport report = run_in_lab(run, {});
  CHECK(report.result.status == 3);
  CHECK(report.result.layers == 10);
  CHECK(report.result.reason.find("tank empty") != std::string::npos);
  ReplayCommandOptions r;
  r.run = run.path().string();
  CHECK(replay_verdict(r).identical());
}
