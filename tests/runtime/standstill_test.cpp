// A computer that stands still: asleep, or a virtual machine that was moved.
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "files/record/record_file.h"
#include "runtime/control_line.h"
#include "runtime/process.h"
#include "runtime/wal_file.h"
#include "tests/runtime/process_nodes.h"

using namespace firn;
using namespace firn::test;

namespace {

/// In the place of safety: works every 10 ms, and keeps the cause of the stop.
class Ticking : public Node {
 public:
  void start(const Start&, Time now, Outbox& out) override { out.wake_at(TimerId{0}, now.after_s(0.01)); }
  void wake(TimerId, Time now, Outbox& out) override { out.wake_at(TimerId{0}, now.after_s(0.01)); }
};

std::string cause_in(const std::filesystem::path& wal) {
  const record::MappedFile mapped(wal);
  record::RecordReader reader(mapped.bytes());
  while (const auto record = reader.next()) {
    if (record->damaged || record->kind != std::uint16_t(WalKind::kEvent)) continue;
    const Event e = decode_event(record->payload).event;
    if (e.kind == EventKind::kLocalStop)
      return {reinterpret_cast<const char*>(e.bytes.data()), e.bytes.size()};
  }
  return {};
}

}  // namespace

TEST_CASE("safety stops a print by name after its computer stood still, and goes on running for the stop") {
  RunDir dir;
  int fd[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fd) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(fd[0]);
    Hub hub;
    Hub::Member bus(hub);
    ProcessOptions o;
    o.node = NodeId::kSafety;
    o.run_dir = dir.path;
    o.run_id = 5;
    o.epoch_ns = monotonic_ns();
    o.control_fd = fd[1];
    o.head = {"safety", 5, 0, "commit", "platform", "", "", {}};
    ::_exit(run_process(o, std::make_unique<Ticking>(), bus));
  }
  ::close(fd[1]);
  ControlLine control(fd[0]);
  for (bool ready = false; !ready;) {
    pollfd p{control.fd(), POLLIN, 0};
    ::poll(&p, 1, 10);
    while (const auto line = control.next()) ready = ready || *line == "READY";
  }
  control.say("START");
  const std::filesystem::path wal = dir.path / "nodes" / "safety.wal";
  for (std::uintmax_t begun = 0; begun < 500;) {
    std::error_code not_yet;
    begun = std::filesystem::file_size(wal, not_yet);
    if (not_yet) begun = 0;
    ::usleep(1000);
  }
  ::kill(child, SIGSTOP);
  ::usleep(1'500'000);
  ::kill(child, SIGCONT);
  std::string cause;
  for (int n = 0; n < 1000 && cause.empty(); ++n) {
    ::usleep(10'000);
    cause = cause_in(wal);
  }
  CHECK_THAT(cause, Catch::StartsWith("this computer stood still for "));
  CHECK(::waitpid(child, nullptr, WNOHANG) == 0);
  control.say("STOP enough");
  int status = -1;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
