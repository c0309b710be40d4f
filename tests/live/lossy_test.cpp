// Randomised prints over a bad network, some with a kill: 10, with `./firn test --full` 200; FIRN_LIVE_RUNS
// sets it.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <numeric>

#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "tests/live/live_checks.h"
#include "tests/support/long_cases.h"

using namespace firn;
using namespace firn::test;

namespace {

/// With FIRN_LIVE_FIRST and FIRN_LIVE_RUNS=1 one of them can be looked at alone.
std::vector<std::size_t> run_numbers() {
  const char *runs = std::getenv("FIRN_LIVE_RUNS"), *first = std::getenv("FIRN_LIVE_FIRST");
  std::vector<std::size_t> numbers =
      runs ? std::vector<std::size_t>(std::size_t(std::atoi(runs))) : long_cases(200, 10);
  if (runs) std::iota(numbers.begin(), numbers.end(), 0);
  for (std::size_t& n : numbers) n += first ? std::size_t(std::atoi(first)) : 0;
  return numbers;
}

Experiment bad_network(std::uint64_t seed, RandomStream& random) {
  Experiment e = tiny_part(seed);
  e.bus.loss = random.uniform(0.0, 0.1);
  e.bus.duplicate = random.uniform(0.0, 0.1);
  e.bus.reorder = random.uniform(0.0, 0.2);
  e.bus.delay = random.uniform(0.0, 0.1);
  e.bus.delay_s = random.uniform(0.0, 0.02);
  e.bus.seed = seed;
  return e;
}

}  // namespace

TEST_CASE(
    "prints over a network that loses, repeats, reorders and delays replay identical, with kills and "
    "without") {
  if (skipped()) return;
  static constexpr const char* kVictims[] = {"scheduler", "surface_mapper", "controller", "stage",
                                             "jet",       "laser_profiler", "lamp",       "recorder",
                                             "safety",    "launcher"};
  int kills = 0;
  for (const std::size_t n : run_numbers()) {
    const std::uint64_t seed = 1000 + std::uint64_t(n);
    RandomStream random(seed, Purpose::kBusFault);
    LiveRun run(bad_network(seed, random));
    INFO("seed " << seed << ", " << run.path());
    run.start(false);
    int status = 0;
    if (random.below(2) == 0) {
      const std::string victim = kVictims[random.below(10)];
      INFO("kill " << victim);
      REQUIRE(run.wait_started());
      ::usleep(useconds_t(random.below(2'500'000)));
      if (run.running()) {
        const std::int64_t at = run.kill(victim);
        status = run.wait();
        run.wait_all_gone();
        if (status != 0) {  // it had not just finished
          ++kills;
          check_safe_after(run, at);
          run.start(true);
          status = run.wait();
        }
      } else {
        status = run.wait();
      }
    } else {
      status = run.wait();
    }
    for (int resumes = 0; status == kSafetyStop && resumes < 2;
         ++resumes) {  // a busy machine: a lease has ended
      run.wait_all_gone();
      run.start(true);
      status = run.wait();
    }
    INFO(run.said());
    CHECK(status == 0);
    CHECK(run.injected() > 0);
    check_finished_run(run);
  }
  if (run_numbers().size() >= 10) CHECK(kills > 0);
}
