// Prints whose instruments are at other computers: network namespaces with an sshd each, behind lines that
// delay, lose and are cut. FIRN_HOST_KILLS=N draws so many moments of loss, FIRN_HOST_SEED=S is the first,
// and FIRN_HOST_LOSS="line cut" fixes the loss.
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string_view>

#include "core/grid/random.h"
#include "files/command.h"
#include "plant/record/record.h"
#include "replay/audit_run.h"
#include "runs/folder/host_record.h"
#include "tests/live/far_hosts.h"
#include "tests/live/live_checks.h"
#include "tests/live/no_hosts.h"
#include "tests/live/other_clock.h"
#include "tests/support/lateness.h"
#include "tests/support/skip.h"

using namespace firn;
using namespace firn::test;

namespace {

/// Stage and jet at the host "bench", profiler and lamp at "attic".
Experiment on_hosts(Experiment e) {
  for (const char* host : {"bench", "attic"})
    e.hosts.address[host] = std::string(host) + ":" FIRN_BINARY_DIR "/bin/firn";
  e.hosts.of_node["stage"] = e.hosts.of_node["jet"] = "bench";
  e.hosts.of_node["laser_profiler"] = e.hosts.of_node["lamp"] = "attic";
  return e;
}

Experiment part_on_hosts(std::uint64_t seed) {
  Experiment e = on_hosts(tiny_part(seed));
  e.run.time_scale = 1.0;
  return e;
}

void slow(FarHosts& hosts) {
  for (const char* host : {"bench", "attic"}) hosts.line(host, 0.020, 0.005, 0.05);
}

std::vector<plant::ShotRecord> shots_of(const LiveRun& run) {
  auto shots = plant::read_history(run.folder().world_record_path()).shots;
  std::erase_if(shots, [](const auto& s) { return s.outcome != plant::ShotOutcome::kFired; });
  return shots;
}

/// A print that no late process has stopped, of which the third counts in any case: one that was resumed may
/// leave a droplet of the broken row out.
std::unique_ptr<LiveRun> printed_at_once(const Experiment& e) {
  constexpr int kTries = 3;
  for (int n = 1;; ++n) {
    auto run = std::make_unique<LiveRun>(e);
    run->start(false);
    CHECK(status_of(*run) == 0);
    if (run->late_stops() == 0 || n == kTries) return run;
  }
}

/// All but the moment.
bool same_droplet(const plant::ShotRecord& a, const plant::ShotRecord& b) {
  return a.i == b.i && a.j == b.j && a.exposures == b.exposures && a.x_mm == b.x_mm && a.y_mm == b.y_mm &&
         a.landed_x_mm == b.landed_x_mm && a.landed_y_mm == b.landed_y_mm && a.volume_mm3 == b.volume_mm3;
}

}  // namespace

TEST_CASE("a print with instruments at two other computers ends as on one, replays and is clean", "[hosts]") {
  if (no_hosts()) return;
  FarHosts hosts({"bench", "attic"});
  LiveRun run(part_on_hosts(5));
  run.start(false);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
  CHECK(runs::incomplete_text(run.path()).empty());
  CHECK(runs::host_records(run.path()).size() == 2);
}

// Where a scan's rows lie depends on the moment at which it began, so that a scheme that looks at its map
// prints two parts that differ by the noise of the map, on one computer too. Given layers show
// the effect of the line alone.
TEST_CASE("a slow line that loses packets changes nothing in the part", "[hosts]") {
  if (no_hosts()) return;
  Experiment e = tiny_part_beside_centres(6);
  e.run.time_scale = 1.0;
  e.plant.drift = 0.0;  // of the jet, with time
  e.run.lease_s = 0.5;  // 0.3 held too, on a computer that does nothing else than this test
  const auto one = printed_at_once(e);
  FarHosts hosts({"bench", "attic"});
  slow(hosts);
  const auto run = printed_at_once(on_hosts(e));
  check_finished_run(*run);
  const auto far = shots_of(*run), near = shots_of(*one);
  CHECK(far.size() == near.size());
  CHECK(std::ranges::equal(far, near, same_droplet));
}

TEST_CASE("hosts that cannot be had are named with what helps, before the first droplet", "[hosts]") {
  if (no_hosts()) return;
  FarHosts hosts({"bench", "attic"});
  const auto said = [&](const std::string& bench) {
    Experiment e = part_on_hosts(7);
    e.hosts.address["bench"] = bench;
    LiveRun run(e);
    run.start(false);
    CHECK(run.wait() == 3);
    CHECK(plant::read_history(run.folder().world_record_path()).shots.empty());
    return run.said();
  };
  CHECK_THAT(said("nowhere"), Catch::Contains("host bench (nowhere) cannot be reached") &&
                                  Catch::Contains("must be one that ssh knows"));
  CHECK_THAT(said("bench:/no/such/firn"),
             Catch::Contains("install firn there") && Catch::Contains("or say where it is"));
  const std::filesystem::path other = hosts.folder() / "firn";  // another build
  std::ofstream(other) << "#!/bin/sh\nexec python3 -B " FIRN_SOURCE_DIR "/tests/support/other_build.py\n";
  std::filesystem::permissions(other, std::filesystem::perms::owner_all);
  CHECK_THAT(said("bench:" + other.string()),
             Catch::Contains("has another build of firn: 0.0.1 (elsewhere)") &&
                 Catch::Contains("firn host --install LAB"));
  std::ofstream(hosts.folder() / "known", std::ios::trunc) << "";
  CHECK_THAT(
      said("bench:" FIRN_BINARY_DIR "/bin/firn"),
      Catch::Contains("its key is unknown or another than before") && Catch::Contains("` once by hand"));
}

TEST_CASE("a computer that is busy before the start, when nothing is at stake, does not lose the print",
          "[hosts]") {
  if (no_hosts()) return;
  constexpr unsigned kBusy_us = 1'500'000;  // well above the longest silence of a print's line
  FarHosts hosts({"bench", "attic"});
  LiveRun run(part_on_hosts(14));
  run.start(false);
  while (!std::filesystem::exists(run.folder().hosts_path() / "bench.facts") && run.running()) ::usleep(1000);
  hosts.freeze("bench");
  ::usleep(kBusy_us);
  hosts.thaw("bench");
  CHECK(run.wait_started());
  CHECK(status_of(run) == 0);
}

TEST_CASE("a clock that is known too badly stops the print before the first droplet", "[hosts]") {
  if (no_hosts()) return;
  FarHosts hosts({"bench", "attic"});
  hosts.line("attic", 0.030, 0.001, 0.0);
  Experiment e = part_on_hosts(8);
  LiveRun run(e);
  run.start(false);
  CHECK(run.wait() == 3);
  // Half of the best of many round trips: near the line's 30 ms, to either side by its jitter.
  CHECK_THAT(run.said(),
             Catch::Contains("host attic") &&
                 Catch::Matches("[^]*has a clock that is known to (2[5-9]|[3-9][0-9])(\\.[0-9]+)? ms[^]*") &&
                 Catch::Contains("run.clock_slack_ms is 20"));
  CHECK(plant::read_history(run.folder().world_record_path()).shots.empty());
}

namespace {

enum class Loss : std::uint8_t { kCutLine, kSshKilled, kFrozen, kRelayKilled, kHostKilled, kDiskFull };
constexpr const char* kLosses[] = {"line cut",     "ssh killed",       "computer frozen",
                                   "relay killed", "firn host killed", "disk full"};

/// A child of the process with this name; 0: it has none.
int child_named(int parent, const std::string& name) {
  const std::string task =
      "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children";
  std::ifstream children(task);
  for (int pid = 0; children >> pid;) {
    std::string comm;
    std::getline(std::ifstream("/proc/" + std::to_string(pid) + "/comm"), comm);
    if (comm == name) return pid;
  }
  return 0;
}

/// In place: processes have the file mapped.
void set_byte(const std::filesystem::path& file, char byte) {
  std::fstream(file, std::ios::in | std::ios::out).put(byte);
}

/// One print that loses a computer in the middle, in the way that the seed draws, and is resumed.
void lose_a_host(std::uint64_t seed) {
  RandomStream random(seed, Purpose::kKill);
  const char* const fixed = std::getenv("FIRN_HOST_LOSS");
  const auto drawn = random.below(std::size(kLosses));
  const auto named = std::ranges::find(kLosses, std::string_view(fixed ? fixed : kLosses[drawn]));
  REQUIRE(named != std::end(kLosses));
  const Loss loss = Loss(named - std::begin(kLosses));
  const std::string host = random.below(2) == 0 ? "bench" : "attic";
  FarHosts hosts({"bench", "attic"});
  Experiment e = part_on_hosts(seed);
  const std::filesystem::path disk = hosts.folder() / "disk";
  if (loss == Loss::kDiskFull) {
    std::ofstream(disk) << '-';
    e.hosts.address[host] =
        host + ":" +
        hosts.firn_with("LD_PRELOAD=" FIRN_DISK_TROUBLE " FIRN_TROUBLE_FOLDER=" +
                        (hosts.folder() / host).string() + " FIRN_TROUBLE_FILE=" + disk.string());
  }
  const Lateness lateness;
  LiveRun run(e);
  INFO("FIRN_HOST_SEED=" << seed << ", " << kLosses[int(loss)] << " of " << host << ", " << run.path());
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(useconds_t(random.below(8'000'000)));
  if (!run.running()) {  // a loaded computer has stopped it before
    CHECK(run.wait_finished() == 0);
    return;
  }
  const std::string relay = "relay_" + host;
  const std::int64_t at = monotonic_ns();
  if (loss == Loss::kCutLine) hosts.cut(host);
  if (loss == Loss::kSshKilled) {
    const int ssh = child_named(run.pid_of(relay), "ssh");
    REQUIRE(ssh > 1);
    ::kill(ssh, SIGKILL);
  }
  if (loss == Loss::kFrozen) hosts.freeze(host);
  if (loss == Loss::kRelayKilled) run.kill(relay);
  if (loss == Loss::kHostKilled)
    for (const int pid : hosts.pids(host)) {
      std::error_code gone;
      if (std::filesystem::read_symlink("/proc/" + std::to_string(pid) + "/exe", gone).filename() == "firn")
        ::kill(pid, SIGKILL);
    }
  if (loss == Loss::kDiskFull) set_byte(disk, 'f');
  const int status = run.wait();
  run.wait_all_gone();
  const double unsafe_s = unsafe_for_s(run, at);
  INFO(run.said());
  if (status != 0) CHECK(status == 3);  // else it was over
  if (status != 0) CHECK_THAT(run.said(), Catch::Contains(host) || Catch::Contains("safe stop"));
  std::printf("seed %d  %s of %s: status %d, last act after %.3f s; this computer was %.3f s late at most\n",
              int(seed), kLosses[int(loss)], host.c_str(), status, unsafe_s, lateness.longest_s());
  std::fflush(stdout);
  // A frozen driver stops nothing: its instrument does by itself.
  CHECK(unsafe_s <= tiny_part(1).run.lease_s + (loss == Loss::kFrozen ? 1.0 : 0.005) + lateness.longest_s());
  const std::string incomplete = runs::incomplete_text(run.path());
  if (!incomplete.empty())
    CHECK_THAT(replay::audit_words(replay::audit_run(run.path())), Catch::Contains(incomplete));
  hosts.mend(host);
  hosts.thaw(host);
  if (loss == Loss::kDiskFull) set_byte(disk, '-');
  if (status == 0) return;
  run.start(true);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
  CHECK(runs::incomplete_text(run.path()).empty());
}

}  // namespace

TEST_CASE("a computer that is lost in mid-print leaves its instruments safe, and the print resumes",
          "[hosts]") {
  if (no_hosts()) return;
  const char* const many = std::getenv("FIRN_HOST_KILLS");
  const char* const first = std::getenv("FIRN_HOST_SEED");
  const int count = many ? std::atoi(many) : 2;
  for (int n = 0; n < count; ++n)
    lose_a_host(std::uint64_t(first ? std::atoll(first) : 11) + std::uint64_t(n));
}

TEST_CASE("a block of ice with arm and valves at another computer is finished, replays and is clean",
          "[hosts]") {
  if (no_hosts()) return;
  FarHosts hosts({"bench"});
  Experiment e = tiny_ice(9);
  e.run.time_scale = 5.0;
  e.hosts.address["bench"] = "bench:" FIRN_BINARY_DIR "/bin/firn";
  for (const char* node : {"robot", "valve_a", "valve_b", "laser_point"}) e.hosts.of_node[node] = "bench";
  LiveRun run(e);
  run.start(false);
  CHECK(status_of(run) == 0);
  check_finished_run(run);
  CHECK(runs::incomplete_text(run.path()).empty());
}

TEST_CASE("a computer whose clock is days off and drifts, and is set meanwhile, changes nothing in the part",
          "[hosts]") {
  if (no_hosts()) return;
  if (run_command({"unshare", "--time", "--fork", "true"}).code != 0)
    return skip("network-namespace", "no namespace with a time of its own");
  Experiment e = tiny_part_beside_centres(10);
  e.run.time_scale = 1.0;
  e.plant.drift = 0.0;  // of the jet, with time
  const auto one = printed_at_once(e);

  FarHosts hosts({"bench", "attic"});
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  constexpr int kDaysAhead = 5;
  ClockError clock{-40 * kDay_ns, 0, 200};
  const std::filesystem::path file = hosts.folder() / "clock";
  const auto set_clock = [&] {
    std::ofstream(file, std::ios::in | std::ios::out | std::ios::app).close();
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
        .write(reinterpret_cast<const char*>(&clock), sizeof clock);
  };
  set_clock();
  e = on_hosts(e);
  e.hosts.address["attic"] =
      "attic:" +
      hosts.firn_with("LD_PRELOAD=" FIRN_OTHER_CLOCK " FIRN_CLOCK_FILE=" + file.string(), kDaysAhead);
  LiveRun run(e);
  run.start(false);
  REQUIRE(run.wait_started());
  for (int n = 0; n < 6 && run.running(); ++n) {
    clock.wall_ns = (n % 2 == 0 ? 1 : -1) * (n + 1) * kDay_ns;
    set_clock();
    ::usleep(700'000);
  }
  CHECK(status_of(run) == 0);
  check_finished_run(run);
  if (run.late_stops() > 0) {
    WARN("resumed: somebody came too late");
    return;
  }
  CHECK(std::ranges::equal(shots_of(run), shots_of(*one), same_droplet));
}
