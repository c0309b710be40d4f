// Live prints on instruments behind TCP and serial lines. The instruments are those of a simulated world that
// the print knows nothing of.
#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "config/devices.h"
#include "config/fields.h"
#include "plant/record/record.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "replay/replayer.h"
#include "tests/live/hardware.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

Experiment small_part(std::uint64_t seed) {
  Experiment e = tiny_part(seed);
  e.run.time_scale = 1.0;
  e.part.shape.height_mm = 0.012;
  e.process.scan_speed_mm_s = 15.0;
  return e;
}

void check_replay_and_audit(const LiveRun& run) {
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(full_product(), run.path()))
    makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions options;
  options.makers = makers;
  CHECK(replay::replay_run(run.path(), options).identical());
  const replay::AuditVerdict audit = replay::audit_run(run.path());
  for (const auto& v : audit.violations) UNSCOPED_INFO(v.what);
  CHECK(audit.clean());
  CHECK_FALSE(audit.with_world);
  REQUIRE_FALSE(audit.notes.empty());
  CHECK_THAT(audit.notes.front(), Contains("REAL: stage (tcp:") && Contains("are not known"));
}

std::int64_t fired(const plant::WorldHistory& h) {
  std::int64_t n = 0;
  for (const auto& shot : h.shots) n += shot.outcome == plant::ShotOutcome::kFired;
  return n;
}

}  // namespace

TEST_CASE("a print on instruments behind TCP and serial lines finishes, replays, and says what is real") {
  if (skipped()) return;
  const Experiment simulated = small_part(71);
  Hardware hardware(simulated);
  Experiment e = simulated;
  hardware.connect(e, false);
  LiveRun run(e);
  INFO(run.path());
  run.start(false);
  CHECK(status_of(run) == 0);
  CHECK_THAT(run.said(), Contains("REAL: stage (tcp:127.0.0.1:") && Contains("SIMULATED: lamp"));
  check_replay_and_audit(run);
  hardware.stop();
  const plant::WorldHistory h = hardware.history();
  CHECK(fired(h) > 20);
  CHECK(replay::audit_run(run.path()).triggered >= 0);
}

TEST_CASE("instruments that lose their power during a print on real lines stop it by name, and it goes on") {
  if (skipped()) return;
  const Experiment simulated = small_part(72);
  Hardware hardware(simulated);
  Experiment e = simulated;
  hardware.connect(e);
  LiveRun run(e);
  INFO(run.path());
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(3'500'000);
  REQUIRE(run.running());
  hardware.stop();
  CHECK(run.wait() == 3);
  run.wait_all_gone();
  CHECK_THAT(run.said(), !Contains("SIMULATED"));
  hardware.start();
  run.start(true);
  CHECK(status_of(run) == 0);
  check_replay_and_audit(run);
}
