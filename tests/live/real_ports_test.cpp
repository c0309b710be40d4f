// Live prints on instruments behind TCP and serial lines. The instruments are those of a simulated world that
// the print knows nothing of.
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <memory>

#include "config/devices.h"
#include "config/fields.h"
#include "plant/record/record.h"
#include "print/folder/taking_part.h"
#include "print/labs/full_product.h"
#include "replay/audit_run.h"
#include "replay/replayer.h"
#include "tests/live/live_checks.h"
#include "tests/live/port_bridge.h"
#include "tests/support/temp_folder.h"

extern char** environ;

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

/// The ink-jet lab as hardware: the world's process on its own, its instruments behind lines.
class Hardware {
 public:
  explicit Hardware(const Experiment& e) {
    std::ofstream(folder_.path() / "experiment.toml") << dump(e);
    start();
    stage_ = std::make_unique<PortBridge>(PortBridge::Kind::kTcp, folder_.path() / "io" / "stage");
    profiler_ =
        std::make_unique<PortBridge>(PortBridge::Kind::kTcp, folder_.path() / "io" / "laser_profiler");
    jet_ = std::make_unique<PortBridge>(PortBridge::Kind::kSerial, folder_.path() / "io" / "jet");
    lamp_ = std::make_unique<PortBridge>(PortBridge::Kind::kSerial, folder_.path() / "io" / "lamp");
  }
  ~Hardware() { stop(); }
  void start() {
    const std::string program = FIRN_BINARY_DIR "/bin/world";
    const std::string run = folder_.path().string(), epoch = std::to_string(monotonic_ns());
    const char* argv[] = {program.c_str(), "--run", run.c_str(), "--epoch-ns", epoch.c_str(), nullptr};
    REQUIRE(::posix_spawn(&pid_, program.c_str(), nullptr, nullptr, const_cast<char**>(argv), environ) == 0);
    for (int n = 0; n < 2000 && !fs::exists(folder_.path() / "io" / "lamp"); ++n) ::usleep(5000);
  }
  void stop() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void connect(Experiment& e, bool lamp = true) const {
    e.run.time_scale = 1.0;
    e.devices.stage = stage_->address();
    e.devices.laser_profiler = profiler_->address();
    e.devices.jet = jet_->address(9600);
    if (lamp) e.devices.lamp = lamp_->address(19200);
  }
  plant::WorldHistory history() const { return plant::read_history(folder_.path() / "world.rec"); }

 private:
  TempFolder folder_;
  pid_t pid_ = -1;
  std::unique_ptr<PortBridge> stage_, profiler_, jet_, lamp_;
};

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
