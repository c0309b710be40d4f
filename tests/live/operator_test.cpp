// Orders of the operator to live prints.
#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "files/exit_codes.h"
#include "files/record/packed.h"
#include "print/operator/operator_client.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/running.h"
#include "tests/live/live_checks.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;

namespace {

constexpr std::int64_t kNumber = 4711;  // of an order, as firn ctl --id gives it

std::string obeyed(const LiveRun& run, const std::vector<std::string>& words,
                   std::int64_t id = new_order_id()) {
  OperatorClient client(run.path());
  OperatorOrder order = parse_order(words);
  order.id = id;
  client.send(order);
  return client.next(20.0).value_or("no answer");
}

/// Runs firn on a terminal of its own, which is closed when it has ended. @returns its exit code
int firn_on_terminal(const std::vector<std::string>& words) {
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  ::grantpt(terminal);
  ::unlockpt(terminal);
  const std::string name = ::ptsname(terminal);
  std::vector<char*> argv;
  for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    ::setsid();
    const int fd = ::open(name.c_str(), O_RDWR);  // the controlling terminal of the new session
    for (const int to : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(fd, to);
    ::execv(FIRN_BINARY_DIR "/bin/firn", argv.data());
    ::_exit(126);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(terminal);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

TEST_CASE("a live print is paused, told more layers, and goes on to its end") {
  if (skipped()) return;
  LiveRun run(tiny_part(51));
  run.start(false);
  REQUIRE(run.wait_started());
  CHECK_THAT(obeyed(run, {"pause"}), Contains("ok pause"));
  CHECK_THAT(obeyed(run, {"set", "control.max_layers=150"}), Contains("ok set"));
  ::usleep(3'000'000);  // longer than the whole print takes
  CHECK(run.running());
  CHECK_THAT(obeyed(run, {"continue"}), Contains("ok continue"));
  CHECK(run.wait_finished() == kOk);
  INFO(run.said());
  CHECK_THAT(run.said(), Contains("the print waits before") && Contains("the print goes on"));
  check_finished_run(run);
}

TEST_CASE("the operator's stop makes a live lab safe, and a resume finishes the print") {
  if (skipped()) return;
  LiveRun run(tiny_part(52));
  run.start(false);
  REQUIRE(run.wait_started());
  ::usleep(700'000);
  const std::int64_t at = monotonic_ns();
  CHECK_THAT(obeyed(run, {"stop"}, kNumber), Contains("ok stop"));
  CHECK(run.wait() == kSafetyStop);
  run.wait_all_gone();
  CHECK_THAT(run.said(), Contains("stopped by the operator"));
  check_safe_after(run, at);
  run.start(true);
  REQUIRE(run.wait_started());
  CHECK_THAT(obeyed(run, {"pause"}, kNumber), Contains("refused order 4711 was 'stop' and is no 'pause'"));
  CHECK(run.wait_finished() == kOk);
  INFO(run.said());
  check_finished_run(run);
}

TEST_CASE("a detached print goes on when the terminal that began it is closed, and attach shows its end") {
  if (skipped()) return;
  LiveRun run(tiny_part(53));
  const std::string folder = run.path().string();
  REQUIRE(firn_on_terminal({"firn", "print", "--resume", folder, "--detach"}) == kOk);
  const auto pid = runs::printing_process(run.path());
  REQUIRE(pid);
  CHECK(*pid != ::getpid());
  CHECK_THROWS_WITH(runs::RunLock(run.path(), runs::RunUse::kRead),
                    Contains("is running (pid " + std::to_string(*pid) + ")"));
  CHECK(firn_on_terminal({"firn", "attach", folder}) == kOk);
  CHECK(record::is_packed(run.path() / "log.lcm"));
  REQUIRE_FALSE(runs::printing_process(run.path()));
  const auto result = run.folder().result();
  REQUIRE(result);
  CHECK(result->outcome == "finished");
  check_finished_run(run);
}

TEST_CASE("firn ctl stop returns when the run can be resumed") {
  if (skipped()) return;
  LiveRun run(tiny_part(54));
  const std::string folder = run.path().string();
  run.start(false);
  REQUIRE(run.wait_started());
  CHECK(firn_on_terminal({"firn", "ctl", folder, "stop"}) == kOk);
  CHECK_FALSE(runs::printing_process(run.path()));
  CHECK(run.wait() == kSafetyStop);
  run.start(true);
  CHECK(run.wait_finished() == kOk);
  INFO(run.said());
  check_finished_run(run);
}
