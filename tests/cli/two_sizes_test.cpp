// Droplets of two sizes through the nodes, killed and resumed: replay, audit and the record of the jet.
#include <catch2/catch.hpp>

#include "firn/enums.h"
#include "firn/jet_command_t.hpp"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/replayer.h"
#include "runs/folder/run_folder.h"
#include "runs/read/run_reader.h"
#include "tests/support/temp_folder.h"

using namespace firn;

TEST_CASE(
    "A print of two sizes of droplet that is killed twice resumes, audits clean and replays to the same "
    "bytes") {
  Experiment e;
  e.grid = {14, 12, 0.263256, 0.263256, 0.0, 0.0};
  e.part.shape.diameter_mm = 2.4;
  e.part.shape.height_mm = 0.03;
  e.control.scheme = "mpc";
  e.control.mpc.error = control::ErrorKind::kSquare;
  e.control.mpc.outside_price = 1.0;
  e.control.mpc.rise_layers = 1.0;
  e.actuation.offsets = OffsetKind::kGrid;
  e.actuation.small_share = 0.5;
  const test::TempFolder folder;
  const runs::RunFolder run =
      runs::RunFolder::create(folder.path(), e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions options;
  LabRunReport report;
  for (const std::uint64_t steps : {900, 700, 0}) {
    options.crash_after_steps = steps;
    report = run_in_lab(full_product(), run, options);
    CHECK(report.crashed == (steps > 0));
    options.resume = true;
  }
  CHECK(report.result.status == 0);
  const replay::AuditVerdict audit = replay::audit_run(run.path());
  INFO(replay::to_text(audit));
  CHECK(audit.clean());
  replay::ReplayOptions replaying;
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(full_product(), run.path()))
    makers.push_back({info(m.id).name, m.make});
  replaying.makers = makers;
  CHECK(replay::replay_run(run.path(), replaying).identical());
  int small = 0, of_first = 0;
  runs::RunReader(run.path()).each<jet_command_t>(channels::kJetCommand.name, [&](const jet_command_t& m) {
    small += JetVerb(m.verb) == JetVerb::kArmSmall;
    of_first += JetVerb(m.verb) == JetVerb::kArm;
  });
  CHECK(small > 1);
  CHECK(of_first > 1);
}
