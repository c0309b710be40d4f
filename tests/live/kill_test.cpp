// kill -9 of live prints: victim, moment and lab are drawn, every process of the print among the victims,
// world and launcher included. 20 kills with a seed of the day. A failure names its seed: FIRN_KILL_SEED=N
// FIRN_KILLS=1 repeats it. FIRN_KILL_VICTIM and FIRN_KILL_LAB (inkjet, two_inks, watched, lines,
// camera_alone, ice, places) fix what is drawn; FIRN_KILL_HARDSHIPS=1 adds to half of the prints a network
// that loses a tenth, and to half a disk that stalls or is full from a moment drawn.
// tests/bench/random_kills.sh makes a table of many.
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "core/grid/random.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

constexpr int kMaxIncarnations = 6;

std::uint64_t first_seed() {
  const char* text = std::getenv("FIRN_KILL_SEED");
  return text ? std::strtoull(text, nullptr, 10) : std::uint64_t(::time(nullptr) / 86'400) * 1000;
}

/// Kills of one test case: a quarter of them.
int kills() {
  const char* text = std::getenv("FIRN_KILLS");
  return text ? std::max(1, std::atoi(text)) : 20;
}

std::string lab_of(RandomStream& random) {
  const std::uint32_t drawn = random.below(20);
  const char* fixed = std::getenv("FIRN_KILL_LAB");
  return fixed        ? fixed
         : drawn == 0 ? "ice"
         : drawn < 6  ? "two_inks"
         : drawn < 9  ? "watched"
         : drawn < 11 ? "lines"
         : drawn < 12 ? "camera_alone"
         : drawn < 15 ? "places"
                      : "inkjet";
}

Experiment print_of(const std::string& lab, std::uint64_t seed) {
  if (lab == "ice") return tiny_ice(seed);
  if (lab == "watched") return tiny_watched_part(seed);
  if (lab == "lines") return tiny_lines(seed);
  if (lab == "camera_alone") return tiny_lines_by_camera(seed);
  if (lab == "places") return tiny_part_beside_centres(seed);
  return lab == "two_inks" ? tiny_part_of_two_inks(seed) : tiny_part(seed);
}

std::string victim_of(const LiveRun& run, RandomStream& random) {
  const std::vector<std::string> names = run.processes();
  const std::uint32_t drawn = random.below(std::uint32_t(names.size()));
  const char* fixed = std::getenv("FIRN_KILL_VICTIM");
  return fixed ? fixed : names[drawn];
}

struct Hardship {
  bool loss = false;
  LiveRun::Disk disk = LiveRun::Disk::kSound;
  std::uint32_t from_us = 0, for_us = 0;  ///< after the start
};

Hardship hardship_of(RandomStream& random, std::uint32_t latest_us) {
  if (!std::getenv("FIRN_KILL_HARDSHIPS")) return {};
  Hardship h;
  h.loss = random.below(2) == 0;
  const std::uint32_t disk = random.below(4);
  h.disk = disk == 0 ? LiveRun::Disk::kStalled : disk == 1 ? LiveRun::Disk::kFull : LiveRun::Disk::kSound;
  h.from_us = random.below(latest_us);
  h.for_us = 100'000 + random.below(4'900'000);
  return h;
}

/// Waits for the print's end; its disk has trouble meanwhile. A full disk stays full until the print has
/// ended.
int wait_in_trouble(LiveRun& run, const Hardship& h) {
  if (h.disk == LiveRun::Disk::kSound) return run.wait();
  const auto sleep_while_running = [&](std::uint32_t us) {
    for (std::uint32_t done = 0; done < us && run.running(); done += 5000) ::usleep(5000);
  };
  sleep_while_running(h.from_us);
  run.set_disk(h.disk);
  if (h.disk == LiveRun::Disk::kStalled) {
    sleep_while_running(h.for_us);
    run.set_disk(LiveRun::Disk::kSound);
  }
  const int status = run.wait();
  run.wait_all_gone();
  run.set_disk(LiveRun::Disk::kSound);
  return status;
}

/// One print, killed once or twice and resumed until it is finished.
void kill_at_random(std::uint64_t seed) {
  RandomStream random(seed, Purpose::kKill);
  const std::string lab = lab_of(random);
  const std::uint32_t latest_us = lab == "ice"                              ? 8'000'000
                                  : lab == "lines" || lab == "camera_alone" ? 5'000'000
                                                                            : 2'300'000;
  std::string story = "seed " + std::to_string(seed) + "  " + lab;
  RandomStream hard(seed, Purpose::kBusFault);
  const Hardship hardship = hardship_of(hard, latest_us);
  Experiment experiment = print_of(lab, seed);
  if (hardship.loss) {
    experiment.bus.loss = 0.1;
    experiment.bus.seed = seed;
    story += "  loss";
  }
  LiveRun run(experiment);
  if (hardship.disk != LiveRun::Disk::kSound) {
    run.set_disk(LiveRun::Disk::kSound);
    story += hardship.disk == LiveRun::Disk::kFull ? "  full" : "  stalled";
  }
  INFO("FIRN_KILL_SEED=" << seed << ", " << run.path());
  int status = -1, left = 1 + int(random.below(4) == 0), incarnations = 0;
  for (; status != 0 && incarnations < kMaxIncarnations; ++incarnations) {
    run.start(incarnations > 0);
    if (incarnations == 0 && hardship.disk != LiveRun::Disk::kSound) {
      status = wait_in_trouble(run, hardship);
      UNSCOPED_INFO("disk trouble after " << hardship.from_us << " us: " << status);
      if (status != 0) CHECK(status == 3);
      if (status == 0) left = 0;
      continue;
    }
    if (left == 0) {
      status = run.wait_finished();
      continue;
    }
    --left;
    REQUIRE(run.wait_started());
    const std::string victim = victim_of(run, random);
    const std::uint32_t after_us = random.below(latest_us);
    ::usleep(useconds_t(after_us));
    if (run.running()) {
      const std::int64_t at = run.kill(victim);
      story += "  " + victim + " " + std::to_string(after_us / 1000) + " ms";
      status = run.wait();
      run.wait_all_gone();
      if (victim != "world") check_safe_after(run, at);
      UNSCOPED_INFO(victim << " killed after " << after_us << " us: " << status);
      if (status != 0) CHECK(status == (victim == "launcher" ? -1 : 3));
    } else {
      status = run.wait();
    }
  }
  INFO(run.said());
  CHECK(status == 0);
  check_finished_run(run);
  std::printf("%s  %d incarnations, status %d\n", story.c_str(), incarnations, status);
  if (std::getenv("FIRN_KILL_SAID")) std::fputs(run.said().c_str(), stdout);
  std::fflush(stdout);
}

void kill_quarter(int quarter) {
  if (skipped()) return;
  for (int n = quarter; n < kills(); n += 4) kill_at_random(first_seed() + std::uint64_t(n));
}

}  // namespace

TEST_CASE("a process killed at random is safe, resumed and replayed, first quarter") { kill_quarter(0); }
TEST_CASE("a process killed at random is safe, resumed and replayed, second quarter") { kill_quarter(1); }
TEST_CASE("a process killed at random is safe, resumed and replayed, third quarter") { kill_quarter(2); }
TEST_CASE("a process killed at random is safe, resumed and replayed, fourth quarter") { kill_quarter(3); }

TEST_CASE("launcher killed: every process stops by itself, resumed, replayed") {
  if (skipped()) return;
  kill_and_resume(tiny_part(20), "launcher", "stage", 20, 0, 1'800'000);
}
TEST_CASE("scheduler killed: safe, named, resumed, replayed", "[I4]") {
  if (skipped()) return;
  kill_and_resume(tiny_part(11), "scheduler", "stage", 11, 0, 1'800'000);
}
TEST_CASE("stage killed while it prints lines: shutter closed, named, resumed, replayed", "[I4]") {
  if (skipped()) return;
  kill_and_resume(tiny_lines(21), "stage", "laser_profiler", 21, 0, 2'300'000);
}
TEST_CASE(
    "stage, jet, scheduler and world killed while droplets are fired beside centres: resumed, replayed, "
    "audited") {
  if (skipped()) return;
  std::uint64_t seed = 31;
  for (const char* victim : {"stage", "jet", "scheduler", "world"}) {
    ++seed;
    kill_and_resume(tiny_part_beside_centres(seed), victim, "stage", seed, 0, 1'800'000);
  }
}
TEST_CASE("world killed: instruments without power, named, resumed, replayed") {
  if (skipped()) return;
  kill_and_resume(tiny_part(12), "world", "stage", 12, 0, 1'800'000);
}
TEST_CASE("a world whose sockets close before it is gone is the cause, not the link that it took along") {
  if (skipped()) return;
  LiveRun run(tiny_part(19));
  const std::string pid_file = (run.path().parent_path() / "world.pid").string();
  run.start(false, programs_with(run.path().parent_path() / "programs", "world",
                                 FIRN_BINARY_DIR "/bin/world \"$@\" & echo $! >" + pid_file + ".part; mv " +
                                     pid_file + ".part " + pid_file + "; wait; sleep 0.1; kill -9 $$"));
  REQUIRE(run.wait_started());
  ::usleep(500'000);
  int pid = 0;
  std::ifstream(pid_file) >> pid;
  REQUIRE(pid > 1);
  ::kill(pid, SIGKILL);
  CHECK(run.wait() == 3);
  run.wait_all_gone();
  INFO(run.said());
  CHECK_THAT(run.said(), Catch::Contains("world was killed by signal 9"));
  CHECK_FALSE(run.folder().result());
  run.start(true);
  CHECK(run.wait_finished() == 0);
  check_finished_run(run);
}
