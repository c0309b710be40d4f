// Random sequences of the operator's orders, kills, SIGSTOP and SIGCONT, SIGHUP and a full disk on live
// prints. Two sequences with a seed of the day. A failure names its seed: FIRN_ORDER_SEED=N FIRN_ORDERS=1
// repeats it; tests/bench/random_orders.sh runs many.
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "print/operator/operator_client.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;

namespace {

namespace fs = std::filesystem;

constexpr int kDisturbed = 2;  // incarnations
constexpr int kMaxLives = 8;

/// The answer, or why there is none: the print may be over, or its launcher dead.
std::string order(const LiveRun& run, const OperatorOrder& what, int times) {
  try {
    OperatorClient client(run.path());
    std::string answer;
    for (int n = 0; n < times; ++n) {
      client.send(what);
      answer = client.next(3.0).value_or("no answer");
    }
    return answer;
  } catch (const std::exception& e) {
    return e.what();
  }
}

class Sequence {
 public:
  explicit Sequence(std::uint64_t seed) : random_(seed, Purpose::kKill), run_(tiny_part(seed)) {
    story_ = "seed " + std::to_string(seed);
  }

  void go() {
    INFO("FIRN_ORDER_SEED, " << story_ << ", " << run_.path());
    int status = -1, incarnations = 0;
    for (; status != kOk && incarnations < kMaxLives; ++incarnations) {
      const bool disturbed = incarnations < kDisturbed;
      run_.start(incarnations > 0, disturbed && random_.below(4) == 0 ? full_disk() : FIRN_BINARY_DIR "/bin");
      if (disturbed && run_.wait_started())
        for (int left = 1 + int(random_.below(4)); left > 0 && run_.running(); --left) {
          ::usleep(random_.below(600'000));
          disturb();
        }
      status = end();
      if (status != kOk && !killed_) {
        INFO(run_.said());
        CHECK((status == kSafetyStop || status == kInterrupted));
        CHECK(named());
      }
    }
    INFO(story_ << "\n" << run_.said());
    CHECK(status == kOk);
    check_finished_run(run_);
    std::printf("%s  %d incarnations, status %d\n", story_.c_str(), incarnations, status);
    std::fflush(stdout);
  }

 private:
  void tell(const std::string& what) { story_ += "  " + what; }

  // One program may write no file beyond some KiB, which is reported like a full disk.
  fs::path full_disk() {
    const char* victims[] = {"recorder", "scheduler", "stage", "laser_profiler", "world", "safety"};
    const std::string victim = victims[random_.below(6)];
    tell("disk of " + victim);
    return programs_with(run_.path().parent_path() / ("programs" + std::to_string(disks_++)), victim,
                         starts(victim, "ulimit -f " + std::to_string(100 + random_.below(900))));
  }

  std::string victim() {
    const std::vector<std::string> names = run_.processes();
    return names[random_.below(std::uint32_t(names.size()))];
  }

  void give(OperatorVerb verb, const std::string& key = "", const std::string& value = "") {
    const OperatorOrder o{new_order_id(), verb, key, value};
    tell(to_text(o));
    order(run_, o, 1 + int(random_.below(3) == 0));
  }

  void disturb() {
    switch (random_.below(9)) {
      case 0:
      case 1:
        give(OperatorVerb::kPause);
        ::usleep(random_.below(900'000));
        return give(OperatorVerb::kContinue);
      case 2:
        return give(OperatorVerb::kPause);  // end() goes on
      case 3:
        return give(OperatorVerb::kSet, "control.max_layers", std::to_string(100 + random_.below(100)));
      case 4:
        return give(OperatorVerb::kFinishLayer);
      case 5:
        return give(random_.below(2) ? OperatorVerb::kStop : OperatorVerb::kAcceptDoubt);
      case 6: {
        const std::string name = victim();
        tell("kill " + name);
        killed_ = killed_ || name == "launcher";
        run_.kill(name);
        return;
      }
      case 7: {
        const std::string name = victim();
        tell("stop and cont " + name);
        ::kill(run_.pid_of(name), SIGSTOP);
        ::usleep(random_.below(800'000));
        ::kill(run_.pid_of(name), SIGCONT);
        return;
      }
      default:
        tell("hang up");
        return run_.signal_all(SIGHUP);
    }
  }

  // A print that is paused goes on.
  int end() {
    for (int n = 0; run_.running(); ++n) {
      ::usleep(50'000);
      if (n % 20 == 19) order(run_, {new_order_id(), OperatorVerb::kContinue, {}, {}}, 1);
    }
    const int status = run_.wait();
    run_.wait_all_gone();
    return status;
  }

  bool named() const {
    const std::string said = run_.said();
    const std::size_t at = std::max(said.rfind("stopped safely: ") + 16, said.rfind("interrupted: ") + 13);
    return said.find("the scheduler said nothing") == std::string::npos && at < said.size();
  }

  RandomStream random_;
  LiveRun run_;
  std::string story_;
  bool killed_ = false;  // the launcher was: nobody can say why the print ended
  int disks_ = 0;
};

}  // namespace

TEST_CASE(
    "a print under random orders, kills, stops, hang-ups and full disks ends finished, clean and identical") {
  if (skipped()) return;
  const char* seed = std::getenv("FIRN_ORDER_SEED");
  const char* orders = std::getenv("FIRN_ORDERS");
  const std::uint64_t first =
      seed ? std::strtoull(seed, nullptr, 10) : std::uint64_t(::time(nullptr) / 86'400) * 1000;
  for (int n = 0; n < (orders ? std::max(1, std::atoi(orders)) : 2); ++n)
    Sequence(first + std::uint64_t(n)).go();
}
