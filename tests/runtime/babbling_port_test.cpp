// A stop, and what is written of a port that sends without end.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "files/record/record_file.h"
#include "runtime/control_line.h"
#include "runtime/ports.h"
#include "runtime/process.h"
#include "runtime/wal_file.h"
#include "tests/runtime/process_nodes.h"

using namespace firn;
using namespace firn::test;

namespace {

/// Sends to whoever connects, as fast as the kernel takes it.
struct Babbler {
  explicit Babbler(const std::filesystem::path& path) {
    listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un a{};
    a.sun_family = AF_UNIX;
    path.string().copy(a.sun_path, sizeof a.sun_path - 1);
    REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
    REQUIRE(::listen(listener, 4) == 0);
    thread = std::thread([this] {
      const std::string babble(1 << 16, 'b');
      for (int fd; (fd = ::accept(listener, nullptr, nullptr)) >= 0; ::close(fd))
        while (::send(fd, babble.data(), babble.size(), MSG_NOSIGNAL) > 0) {
        }
    });
  }
  ~Babbler() {
    ::shutdown(listener, SHUT_RDWR);
    thread.join();
    ::close(listener);
  }
  int listener;
  std::thread thread;
};

bool says(ControlLine& control, const std::string& start) {
  for (int n = 0; n < 6000; ++n) {
    while (const auto line = control.next())
      if (line->starts_with(start)) return true;
    pollfd p{control.fd(), POLLIN, 0};
    ::poll(&p, 1, 10);
  }
  return false;
}

}  // namespace

TEST_CASE(
    "a driver whose instrument babbles stops when it is told to, and writes no more than the port's rate") {
  RunDir dir;
  const std::filesystem::path wal = dir.path / "nodes" / "jet.wal";
  int ended = -1;
  {
    const Babbler instrument(dir.path / "io" / "jet");
    Hub hub;
    int fd[2];
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fd) == 0);
    ControlLine control(fd[0]);
    std::thread driver([&] {
      Hub::Member bus(hub);
      ProcessOptions o;
      o.node = NodeId::kJet;
      o.run_dir = dir.path;
      o.run_id = 5;
      o.epoch_ns = monotonic_ns();
      o.control_fd = fd[1];
      o.head = {"jet", 5, 0, "commit", "platform", "", "", {}};
      ended = run_process(o, std::make_unique<Echo>(), bus);
    });
    CHECK(says(control, "READY"));
    control.say("START");
    while (!std::filesystem::exists(wal) || std::filesystem::file_size(wal) < 50'000) ::usleep(1000);
    control.say("STOP enough");
    driver.join();
  }
  CHECK(ended == 0);
  CHECK(std::filesystem::file_size(wal) < 1'000'000);
  const record::MappedFile mapped(wal);
  record::RecordReader reader(mapped.bytes());
  std::size_t largest = 0;
  bool stopped = false;
  while (const auto record = reader.next()) {
    if (record->kind != std::uint16_t(WalKind::kEvent)) continue;
    const Event e = decode_event(record->payload).event;
    largest = std::max(largest, e.bytes.size());
    stopped = stopped || e.kind == EventKind::kLocalStop;
  }
  CHECK(largest <= Ports::kReadPerTurn);
  CHECK(stopped);
}
