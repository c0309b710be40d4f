// Ports over TCP and over a serial line: a pseudo terminal stands for the line, its master for the
// instrument.
#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <optional>

#include "runtime/ports.h"
#include "runtime/run_clock.h"
#include "runtime/serial_line.h"

using namespace firn;
using Catch::Contains;

namespace {

/// A serial line whose other end a test holds.
struct Line {
  Line() { REQUIRE(::openpty(&master, &slave, name, nullptr, nullptr) == 0); }
  ~Line() { unplug(); }
  void unplug() {
    if (slave >= 0) ::close(slave);
    if (master >= 0) ::close(master);
    master = slave = -1;
  }
  PortAddress address(int open_wait_ms = 0) const {
    return parse_port_address("serial:" + std::string(name) +
                              "?baud=9600&open_wait_ms=" + std::to_string(open_wait_ms));
  }
  int master = -1, slave = -1;
  char name[128];
};

struct Server {
  Server() {
    fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof a;
    REQUIRE(::bind(fd, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
    REQUIRE(::listen(fd, 4) == 0);
    REQUIRE(::getsockname(fd, reinterpret_cast<sockaddr*>(&a), &size) == 0);
    port = ntohs(a.sin_port);
  }
  ~Server() { ::close(fd); }
  PortAddress address() const { return parse_port_address("tcp:127.0.0.1:" + std::to_string(port)); }
  int fd = -1, port = 0;
};

struct Bench {
  explicit Bench(const PortAddress& address) : ports({address}) { ports.open_all(monotonic_us()); }
  void service() {
    ports.service(
        monotonic_us(), [&](PortId, LinkState s) { links.push_back(s); },
        [&](PortId, std::span<const std::byte> b) {
          text.append(reinterpret_cast<const char*>(b.data()), b.size());
        });
    for (std::string& n : ports.take_notices()) notices.push_back(std::move(n));
  }
  template <class Done>
  bool until(Done done, int within_ms = 3000) {
    const std::int64_t end = monotonic_us() + within_ms * 1000;
    while (!done() && monotonic_us() < end) {
      service();
      ::usleep(1000);
    }
    return done();
  }
  bool open() {
    return until([&] { return !links.empty() && links.back() == LinkState::kOpen; });
  }
  void write(std::string_view bytes) { ports.write(PortId{0}, std::as_bytes(std::span(bytes)), false); }

  Ports ports;
  std::vector<LinkState> links;
  std::string text;
  std::vector<std::string> notices;
};

std::string read_all(int fd, std::size_t wanted, int within_ms = 2000) {
  std::string text;
  char b[8192];
  pollfd p{fd, POLLIN, 0};
  while (text.size() < wanted && ::poll(&p, 1, within_ms) > 0) {
    const ssize_t got = ::read(fd, b, sizeof b);
    if (got <= 0) break;
    text.append(b, std::size_t(got));
  }
  return text;
}

}  // namespace

TEST_CASE("every byte passes a serial line unchanged in both directions") {
  Line line;
  Bench bench(line.address());
  REQUIRE(bench.open());
  std::string all;
  for (int n = 0; n < 256; ++n) all += char(n);
  bench.write(all);
  bench.service();
  CHECK(read_all(line.master, 256) == all);
  REQUIRE(::write(line.master, all.data(), all.size()) == 256);
  CHECK(bench.until([&] { return bench.text.size() >= 256; }));
  CHECK(bench.text == all);
}

TEST_CASE("a serial line that is pulled out is told closed, and opens again when it is back") {
  Line line;
  Bench bench(line.address());
  REQUIRE(bench.open());
  const std::string name = line.name;
  line.unplug();
  REQUIRE(bench.until([&] { return bench.links.back() == LinkState::kClosed; }));
  bench.ports.reopen(PortId{0}, monotonic_us());
  CHECK(bench.until([&] { return !bench.notices.empty(); }));
  CHECK_THAT(bench.notices.at(0), Contains(name));
  std::vector<Line> others(1);  // the system gives the lowest free number again
  REQUIRE(std::string(others[0].name) == name);
  CHECK(bench.until([&] { return bench.links.back() == LinkState::kOpen; }));
  CHECK(bench.links == std::vector{LinkState::kOpen, LinkState::kClosed, LinkState::kOpen});
}

TEST_CASE("a second opener of a serial line is refused at once, and told who holds it") {
  Line line;
  const pid_t bystander = ::fork();  // has it open too, and does not use it
  if (bystander == 0)
    for (;;) ::pause();
  const pid_t child = ::fork();
  if (child == 0) {
    std::string why;
    const int fd = open_serial_line(line.address(), why);
    ::close(line.master);
    ::close(line.slave);
    if (fd < 0) ::_exit(1);
    for (;;) ::pause();
  }
  std::string why;
  int second = -1;
  for (int n = 0; n < 200 && why.empty(); ++n) {  // until the child has it
    second = open_serial_line(line.address(), why);
    if (second >= 0) ::close(second);
    ::usleep(10'000);
  }
  const std::int64_t before = monotonic_us();
  why.clear();
  CHECK(open_serial_line(line.address(), why) == -1);
  CHECK(monotonic_us() - before < 1'000'000);
  CHECK_THAT(why, Contains("in use") && Contains("process " + std::to_string(child)));
  for (const pid_t pid : {child, bystander}) {
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
  }
}

TEST_CASE("nothing is written to a serial line before its time to wake up is over") {
  Line line;
  Bench bench(line.address(300));
  const std::int64_t began = monotonic_us();
  REQUIRE(bench.open());
  CHECK(monotonic_us() - began >= 290'000);
}

TEST_CASE("a line that wakes up is not begun anew by a driver that asks again") {
  Line line;
  Bench bench(line.address(1000));
  const std::int64_t began = monotonic_us();
  bench.until([&] { return monotonic_us() - began > 600'000; });
  bench.ports.reopen(PortId{0}, monotonic_us());
  CHECK(bench.until([&] { return !bench.links.empty(); }, 800));
  CHECK(bench.links == std::vector{LinkState::kOpen});
}

TEST_CASE("a file that is no serial line is named") {
  std::string why;
  CHECK(open_serial_line(parse_port_address("serial:/dev/null?baud=9600"), why) == -1);
  CHECK_THAT(why, Contains("/dev/null is no serial line"));
  CHECK(open_serial_line(parse_port_address("serial:/dev/firn-none?baud=9600"), why) == -1);
  CHECK_THAT(why, Contains("/dev/firn-none: No such file"));
}

TEST_CASE("a stop does not wait behind what a slow line has not sent") {
  Line line;
  Bench bench(line.address());
  REQUIRE(bench.open());
  const std::string long_text(6000, 'x');
  bench.write(long_text);
  bench.service();
  bench.ports.drop_waiting(PortId{0});
  bench.write("STOP");
  bench.service();
  const std::string seen = read_all(line.master, 6004, 200);
  CHECK(seen.size() < 6004);  // a pseudo terminal hands on at once what it has taken
  CHECK(seen.ends_with("STOP"));
}

TEST_CASE("a second stop does not take back what the first one has written, nor what makes safe after it") {
  for (const bool asked_again : {false, true}) {
    Line line;
    Bench bench(line.address());
    REQUIRE(bench.open());
    bench.ports.write(PortId{0}, std::as_bytes(std::span("FIRE", 4)), true);
    bench.service();
    bench.ports.drop_waiting(PortId{0});  // local stop of a print's end,
    bench.write("STOP");
    if (asked_again) {
      bench.service();
      bench.write("SAFE?");
    }
    bench.ports.drop_waiting(PortId{0});  // and SAFE_STOP, 30 us later: a line of 9600 baud has sent nothing
    bench.service();
    CAPTURE(asked_again);
    CHECK_THAT(read_all(line.master, 4096, 200), Catch::EndsWith(asked_again ? "STOPSAFE?" : "STOP"));
  }
}

TEST_CASE("a stop overtakes a command, also one that came after an earlier stop") {
  Line line;
  Bench bench(line.address());
  REQUIRE(bench.open());
  bench.ports.drop_waiting(PortId{0});
  bench.write("STOP");
  bench.service();
  REQUIRE(read_all(line.master, 4, 500) == "STOP");
  const std::string order(6000, 'x');
  bench.ports.write(PortId{0}, std::as_bytes(std::span(order)), true);
  bench.service();
  bench.ports.drop_waiting(PortId{0});
  bench.write("STOP");
  bench.service();
  const std::string seen = read_all(line.master, 6004, 200);
  CHECK(seen.size() < 6004);
  CHECK(seen.ends_with("STOP"));
}

TEST_CASE("a TCP port carries bytes, is told closed when the instrument goes, and connects again") {
  Server server;
  Bench bench(server.address());
  REQUIRE(bench.open());
  int peer = ::accept(server.fd, nullptr, nullptr);
  bench.write("ping");
  bench.service();
  CHECK(read_all(peer, 4) == "ping");
  ::close(peer);
  REQUIRE(bench.until([&] { return bench.links.back() == LinkState::kClosed; }));
  bench.ports.reopen(PortId{0}, monotonic_us());
  CHECK(bench.open());
  peer = ::accept(server.fd, nullptr, nullptr);
  REQUIRE(::send(peer, "pong", 4, 0) == 4);
  CHECK(bench.until([&] { return bench.text == "pong"; }));
  ::close(peer);
}

TEST_CASE("a connection that the instrument ends is told with its address, until it is there again") {
  Server server;
  Bench bench(server.address());
  REQUIRE(bench.open());
  ::close(::accept(server.fd, nullptr, nullptr));
  REQUIRE(bench.until([&] { return bench.links.back() == LinkState::kClosed; }));
  bench.service();
  const std::string lost = to_text(server.address()) + ": the other side has closed it";
  CHECK(bench.notices == std::vector{lost});
  CHECK(bench.ports.trouble() == lost);
  bench.ports.reopen(PortId{0}, monotonic_us());
  REQUIRE(bench.open());
  CHECK(bench.ports.trouble().empty());
}

TEST_CASE("a serial line that is pulled out is told gone, with its name") {
  Line line;
  Bench bench(line.address());
  REQUIRE(bench.open());
  line.unplug();
  REQUIRE(bench.until([&] { return !bench.notices.empty(); }));
  CHECK_THAT(bench.notices.at(0), Contains(std::string(line.name)) && Contains("the line is gone"));
}

TEST_CASE("a TCP port that nobody serves is named once, and tried again until somebody does") {
  std::optional<Server> server(std::in_place);
  const PortAddress address = server->address();
  server.reset();
  Bench bench(address);
  CHECK_FALSE(bench.until([&] { return !bench.links.empty(); }, 700));
  REQUIRE(bench.notices.size() == 1);
  CHECK_THAT(bench.notices[0], Contains(to_text(address)) && Contains("refused"));
}

TEST_CASE("a host that no name service knows is refused before anything starts") {
  CHECK_THROWS_WITH(PortWire(parse_port_address("tcp:no-such-host.invalid:4000")),
                    Contains("tcp:no-such-host.invalid:4000") && Contains("not known"));
}
