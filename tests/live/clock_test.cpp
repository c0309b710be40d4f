// Live prints whose clocks step, leap or drift.
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "print/operator/operator_client.h"
#include "tests/live/live_checks.h"
#include "tests/live/other_clock.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kSecond_ns = 1'000'000'000, kYear_ns = 31'556'952 * kSecond_ns;

/// The clocks of a computer, and `firn print --resume` of a run on it.
class OtherComputer {
 public:
  explicit OtherComputer(const fs::path& run) : run_(run) { set({}); }
  ~OtherComputer() {
    if (pid_ > 0) ::kill(pid_, SIGKILL);
  }

  void set(const ClockError& error) {
    const int fd = ::open(file().c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    REQUIRE(::pwrite(fd, &error, sizeof error, 0) == ssize_t(sizeof error));
    ::close(fd);
  }
  void print(bool in_process = false) {
    pid_ = ::fork();
    if (pid_ != 0) return;
    ::setenv("LD_PRELOAD", FIRN_OTHER_CLOCK, 1);
    ::setenv("FIRN_CLOCK_FILE", file().c_str(), 1);
    const int out = ::open((folder_.path() / "said").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    for (const int to : {STDOUT_FILENO, STDERR_FILENO}) ::dup2(out, to);
    const std::string run = run_.string();
    std::vector<const char*> words{"firn", "print", "--resume", run.c_str(), "--plain"};
    if (in_process) words.insert(words.end(), {"--bus", "in-process"});
    words.push_back(nullptr);
    ::execv(FIRN_BINARY_DIR "/bin/firn", const_cast<char**>(words.data()));
    ::_exit(126);
  }
  /// Waits until all processes of the print have begun.
  void await_begun() {
    for (; running(); ::usleep(10'000)) try {
        OperatorClient client(run_);
        client.say("state");
        if (client.next(30.0)) return;
      } catch (const std::exception&) {  // there is no desk yet
      }
  }
  bool running() {
    if (pid_ > 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) pid_ = -1;
    return pid_ > 0;
  }
  void interrupt() const {
    REQUIRE(pid_ > 0);  // -1 is every process
    ::kill(pid_, SIGINT);
  }
  int wait() {
    if (pid_ > 0) ::waitpid(pid_, &status_, 0);
    pid_ = -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
  }
  std::string said() const {
    std::ifstream in(folder_.path() / "said");
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  fs::path file() const { return folder_.path() / "clocks"; }

  TempFolder folder_;
  fs::path run_;
  pid_t pid_ = -1;
  int status_ = 0;
};

/// Steps the wall clock every 50 ms, by 30 s to 30 years forwards or back.
void step_while_running(OtherComputer& computer, RandomStream& random) {
  while (computer.running()) {
    const std::int64_t size_ns = random.below(2) ? std::int64_t(30 + random.below(86'400)) * kSecond_ns
                                                 : std::int64_t(1 + random.below(30)) * kYear_ns;
    computer.set({.wall_ns = random.below(2) ? size_ns : -size_ns});
    ::usleep(50'000);
  }
}

}  // namespace

TEST_CASE(
    "steps of the wall clock in a print and before its resume change nothing, live and in one process") {
  if (skipped()) return;
  for (const bool in_process : {false, true}) {
    CAPTURE(in_process);
    RandomStream random(in_process, Purpose::kTest);
    LiveRun run(tiny_part(91));
    OtherComputer computer(run.path());
    if (!in_process) {
      computer.print();
      computer.await_begun();
      computer.set({.wall_ns = -30 * kYear_ns});
      ::usleep(200'000);
      computer.interrupt();
      REQUIRE(computer.wait() == kInterrupted);
      computer.set({.wall_ns = 30 * kYear_ns});
    }
    computer.print(in_process);
    step_while_running(computer, random);
    const int status = computer.wait();
    INFO(computer.said());
    CHECK(status == kOk);
    check_finished_run(run);
  }
}

TEST_CASE("a clock that drifts against its instruments' by a thousandth changes no verdict of a print") {
  if (skipped()) return;
  for (const std::int64_t ppm : {1000, -1000}) {
    CAPTURE(ppm);
    LiveRun run(tiny_part(93));
    const TempFolder folder;
    const ClockError drift{.drift_ppm = ppm};
    const fs::path file = folder.file("clocks", {reinterpret_cast<const char*>(&drift), sizeof drift});
    run.start(false, programs_with(folder.path() / "programs", "world",
                                   starts("world", "export LD_PRELOAD=" FIRN_OTHER_CLOCK " FIRN_CLOCK_FILE=" +
                                                       file.string())));
    CHECK(status_of(run) == kOk);
    check_finished_run(run);
  }
}
