// Signals, closed pipes, run folders that move, and second prints: a live print goes on or ends safe, with a
// word and with its files whole.
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>

#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "runs/folder/lab_lock.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

namespace fs = std::filesystem;

void finish(LiveRun& run) {
  run.start(true);
  const int status = run.wait_finished();
  INFO(run.said());
  CHECK(status == kOk);
  check_finished_run(run);
}

// firn itself, with a pipe for stdout and stderr whose reader has gone. @returns the exit code, -signal
int firn_into_closed_pipe(const std::vector<std::string>& words) {
  int ends[2];
  REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
  ::close(ends[0]);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    std::vector<char*> argv;
    for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
    argv.push_back(nullptr);
    ::execv(FIRN_BINARY_DIR "/bin/firn", argv.data());
    ::_exit(126);
  }
  ::close(ends[1]);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

}  // namespace

TEST_CASE("Ctrl-Z does not freeze a lab: the print goes on to its end") {
  if (skipped()) return;
  LiveRun run(tiny_part(31));
  run.start(false);
  REQUIRE(run.wait_started());
  for (int n = 0; n < 3; ++n) {
    ::usleep(200'000);
    run.signal_all(SIGTSTP);
  }
  CHECK(status_of(run) == kOk);
  check_finished_run(run);
}

TEST_CASE(
    "the end of the terminal makes the lab safe, ends the print with a word, and a resume finishes it") {
  if (skipped()) return;
  LiveRun run(tiny_part(32));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(600'000);
  const std::int64_t at = monotonic_ns();
  run.signal_all(SIGHUP);
  CHECK(run.wait() == kInterrupted);
  run.wait_all_gone();
  CHECK_THAT(run.said(), Contains("interrupted by the operator"));
  check_safe_after(run, at);
  finish(run);
}

TEST_CASE("a computer that stands still stops the print by name, and a resume finishes it") {
  if (skipped()) return;
  LiveRun run(tiny_part(37));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(600'000);
  run.signal_all(SIGSTOP);
  ::usleep(2'000'000);
  run.signal_all(SIGCONT);
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  REQUIRE(run.folder().result());
  CHECK_THAT(run.folder().result()->reason, Contains("this computer stood still for "));
  finish(run);
}

TEST_CASE("a print whose stdout and stderr nobody reads goes on to its end, live and in one process") {
  if (skipped()) return;
  LiveRun run(tiny_part(33));
  CHECK(firn_into_closed_pipe({"firn", "print", "--resume", run.path().string()}) == kOk);
  check_finished_run(run);
  LiveRun memory(tiny_part(34));
  CHECK(firn_into_closed_pipe({"firn", "print", "--resume", memory.path().string(), "--bus", "in-process"}) ==
        kOk);
  check_finished_run(memory);
}

TEST_CASE("Ctrl-C before every process is ready ends with 130, and a resume begins the print") {
  if (skipped()) return;
  LiveRun run(tiny_part(35));
  run.start(false, programs_with(run.path().parent_path() / "programs", "lamp", "exec sleep 60"));
  while (!fs::exists(run.path() / "pids") || !fs::exists(run.path() / "nodes" / "jet.wal")) ::usleep(5000);
  run.interrupt();
  CHECK(run.wait() == kInterrupted);
  CHECK_THAT(run.said(), Contains("interrupted before the start"));
  CHECK_FALSE(run.folder().result());
  finish(run);
}

TEST_CASE("Ctrl-C before a resumed print is ready leaves a run that the next resume finishes") {
  if (skipped()) return;
  LiveRun run(tiny_part(36));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(700'000);
  run.interrupt();
  CHECK(run.wait() == kInterrupted);
  run.wait_all_gone();
  run.start(true, programs_with(run.path().parent_path() / "programs", "lamp", "exec sleep 60"));
  ::usleep(400'000);
  run.interrupt();
  CHECK(run.wait() == kInterrupted);
  finish(run);
}

TEST_CASE("a live print whose world was killed goes on in one process") {
  if (skipped()) return;
  LiveRun run(tiny_part(42));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(1'100'000);
  run.kill("world");
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  LabRunOptions options;
  options.resume = true;
  const runs::RunResult result =
      run_in_lab(full_product(), runs::RunFolder::open(run.path()), options).result;
  INFO(result.reason);
  CHECK(result.status == kOk);
  check_finished_run(run);
}

TEST_CASE("a run folder that is moved during a live print stops it by name, and it goes on where it is now") {
  if (skipped()) return;
  LiveRun run(tiny_part(37));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(100'000);
  const fs::path moved = run.path().parent_path() / "moved";
  fs::rename(run.path(), moved);
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  CHECK_THAT(run.said(), Contains("the run folder " + run.path().string() + " was moved to ") &&
                             Contains(moved.string()));
  fs::rename(moved, run.path());
  finish(run);
}

TEST_CASE("a run folder that is deleted during a live print stops it by name") {
  if (skipped()) return;
  LiveRun run(tiny_part(38));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(300'000);
  while (fs::exists(run.path())) {
    std::error_code busy;
    fs::remove_all(run.path(), busy);
  }
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  CHECK_THAT(run.said(), Contains("the run folder " + run.path().string() + " was deleted"));
}

TEST_CASE(
    "a second print of a run, or with its instruments, is refused by process and run folder until all are "
    "gone") {
  if (skipped()) return;
  LiveRun first(tiny_part(39)), second(tiny_part(40));
  const fs::path lab = first.path().parent_path() / "lab";
  fs::create_directory(lab);
  for (const LiveRun* run : {&first, &second}) {
    fs::remove(run->path() / "io");
    fs::create_directory_symlink(lab, run->path() / "io");
  }
  first.start(false);
  REQUIRE(first.wait_started());
  LaunchOptions options;
  const std::string holder =
      "process " + std::to_string(first.pid_of("launcher")) + ", run folder " + first.path().string();
  CHECK_THROWS_AS(launch(full_product(), runs::RunFolder::open(second.path()), options), UsageError);
  CHECK_THROWS_WITH(launch(full_product(), runs::RunFolder::open(second.path()), options),
                    Contains("the lab in " + lab.string() + " is in use by " + holder));
  options.resume = true;
  CHECK_THROWS_WITH(launch(full_product(), runs::RunFolder::open(first.path()), options),
                    Contains("is running (pid " + std::to_string(first.pid_of("launcher")) + ")"));
  first.kill("launcher");
  CHECK(first.wait() == -1);
  second.start(false);  // waits for the processes that the launcher left behind
  CHECK(status_of(second) == kOk);
  check_finished_run(second);
  finish(first);
}

TEST_CASE("an instrument that two run folders link to, and a bus by name, are locked too") {
  if (skipped()) return;
  Experiment e = tiny_part(41);
  LiveRun first(e), second(e);
  for (const LiveRun* run : {&first, &second}) fs::create_symlink("/dev/null", run->path() / "io" / "stage");
  const runs::RunFolder a = runs::RunFolder::open(first.path()), b = runs::RunFolder::open(second.path());
  {
    const runs::LabLock held(a, e, "", runs::LabLock::Heirs::kNobody);
    CHECK_THROWS_WITH(runs::LabLock(b, e, "", runs::LabLock::Heirs::kNobody),
                      Contains("the instrument at /dev/null is in use by process " +
                               std::to_string(::getpid()) + ", run folder " + first.path().string()));
  }
  fs::remove(second.path() / "io" / "stage");
  const std::string bus = "udpm://239.255.76.67:21999";
  const runs::LabLock held(a, e, bus + "?ttl=0", runs::LabLock::Heirs::kNobody);
  CHECK_THROWS_WITH(runs::LabLock(b, e, bus + "?ttl=1", runs::LabLock::Heirs::kNobody),
                    Contains("the bus " + bus));
  CHECK_NOTHROW(runs::LabLock(b, e, "", runs::LabLock::Heirs::kNobody));
}
