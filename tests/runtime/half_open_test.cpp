// A TCP link whose other side has gone without a word: in a network namespace of the test's own the
// interface goes down, so that neither an acknowledgement nor a reset comes back.
#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "runtime/ports.h"
#include "runtime/run_clock.h"
#include "tests/support/skip.h"

using namespace firn;

namespace {

struct Measured {
  bool permitted = false, worked = false;
  double noticed_s = -1.0;  ///< from the interface's end to the event
  double usable_s = -1.0;   ///< from its return to an answer
};

void interface_up(bool up) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  ifreq r{};
  std::strncpy(r.ifr_name, "lo", IFNAMSIZ - 1);
  r.ifr_flags = short(up ? IFF_UP | IFF_RUNNING : 0);
  (void)::ioctl(fd, SIOCSIFFLAGS, &r);
  ::close(fd);
}

/// An instrument that returns each byte.
class Echo {
 public:
  Echo() {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    a.sin_port = htons(kPort);
    (void)!::bind(listener_, reinterpret_cast<sockaddr*>(&a), sizeof a);
    (void)!::listen(listener_, 4);
  }
  void serve() {
    if (const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK); fd >= 0) fd_ = fd;
    char bytes[256];
    const ssize_t got = fd_ >= 0 ? ::recv(fd_, bytes, sizeof bytes, 0) : 0;
    if (got > 0) (void)!::send(fd_, bytes, std::size_t(got), MSG_NOSIGNAL);
  }
  static constexpr int kPort = 24691;

 private:
  int listener_ = -1, fd_ = -1;
};

/// @param asked bytes are under way when the link dies
Measured half_open(bool asked) {
  Measured m;
  if (::unshare(CLONE_NEWNET) != 0) return m;
  m.permitted = true;
  interface_up(true);
  Echo instrument;
  Ports ports({parse_port_address("tcp:127.0.0.1:" + std::to_string(Echo::kPort))});
  ports.open_all(monotonic_us());
  LinkState link = LinkState::kClosed;
  std::string heard;
  std::int64_t closed_us = 0;
  constexpr std::int64_t kFirstPause_us = 100'000;
  const auto until = [&](auto done, double within_s) {
    const std::int64_t begin_us = monotonic_us();
    while (!done() && monotonic_us() - begin_us < std::int64_t(within_s * 1e6)) {
      instrument.serve();
      if (closed_us > 0 && monotonic_us() - closed_us > kFirstPause_us) {  // as a driver does
        closed_us = 0;
        ports.reopen(PortId{0}, monotonic_us());
      }
      ports.service(
          monotonic_us(),
          [&](PortId, LinkState s) {
            link = s;
            if (s == LinkState::kClosed) closed_us = monotonic_us();
          },
          [&](PortId, std::span<const std::byte> b) {
            heard.append(reinterpret_cast<const char*>(b.data()), b.size());
          });
      ::usleep(2000);
    }
    return done() ? double(monotonic_us() - begin_us) * 1e-6 : -1.0;
  };
  const auto write = [&](std::string_view text) {
    ports.write(PortId{0}, std::as_bytes(std::span(text.data(), text.size())), false);
  };
  const auto answered = [&](double within_s) {
    heard.clear();
    if (until([&] { return link == LinkState::kOpen; }, within_s) < 0.0) return false;
    write("?");
    return until([&] { return heard == "?"; }, within_s) >= 0.0;
  };
  m.worked = answered(3.0);
  interface_up(false);
  if (asked) write("MOVE");
  m.noticed_s = until([&] { return link == LinkState::kClosed; }, 20.0);
  heard.clear();
  interface_up(true);
  const std::int64_t back_us = monotonic_us();
  if (answered(20.0)) m.usable_s = double(monotonic_us() - back_us) * 1e-6;
  m.worked = m.worked && heard == "?";  // and nothing that was under way comes again
  return m;
}

Measured in_a_child(bool asked) {
  int pipe[2];
  REQUIRE(::pipe(pipe) == 0);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const Measured m = half_open(asked);
    (void)!::write(pipe[1], &m, sizeof m);
    ::_exit(0);
  }
  Measured m;
  CHECK(::read(pipe[0], &m, sizeof m) == ssize_t(sizeof m));
  int status = 0;
  CHECK(::waitpid(child, &status, 0) == child);
  for (const int fd : pipe) ::close(fd);
  return m;
}

}  // namespace

TEST_CASE(
    "a TCP link whose other side has gone without a word is noticed within 5 s and used again within 5 s",
    "[I2]") {
  for (const bool asked : {true, false}) {
    CAPTURE(asked);
    const Measured m = in_a_child(asked);
    if (!m.permitted) return test::skip("network-namespace", "a network namespace is not permitted here");
    CHECK(m.worked);
    CHECK(m.noticed_s > 0.5);
    CHECK(m.noticed_s <= 5.0);
    CHECK(m.usable_s >= 0.0);
    CHECK(m.usable_s <= 5.0);
  }
}
