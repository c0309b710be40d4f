// Ports of simulated instruments that are reached over the line to another computer.
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include "procs/relay/port_tunnel.h"
#include "runtime/port_wire.h"
#include "runtime/socket_address.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::relay;

namespace {

/// Drivers at one end of a link, the world's sockets at the other, and as many further lanes as are wanted.
struct Tunnelled {
  explicit Tunnelled(int lanes = 0, std::vector<std::string> ports = {"jet", "laser_profiler"}) {
    std::array<int, 2> s = pair();
    far.emplace(s[0]);
    near.emplace(s[1]);
    for (int n = 0; n < lanes; ++n) {
      s = pair();
      far->add_lane(s[0]);
      near->add_lane(s[1]);
    }
    drivers.emplace(PortTunnel::Side::kDrivers, folder.path() / "drivers", ports, *far);
    instruments.emplace(PortTunnel::Side::kInstruments, folder.path() / "world", ports, *near);
    std::filesystem::create_directories(folder.path() / "world");
  }
  static std::array<int, 2> pair() {
    std::array<int, 2> s{};
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, s.data()) == 0);
    return s;
  }
  void turn() {
    drivers->service();
    instruments->service();
    far->service([&](const Frame& f) { drivers->take(f); });
    near->service([&](const Frame& f) { instruments->take(f); });
  }
  /// Turns until it holds, which a test waits for with all patience.
  void until(const std::function<bool()>& holds) {
    bool held = holds();
    for (int n = 0; n < 200'000 && !held; ++n) {
      turn();
      held = holds();
    }
    REQUIRE(held);
  }
  std::filesystem::path driver_port(const std::string& port) const {
    return folder.path() / "drivers" / port;
  }
  std::filesystem::path world_port(const std::string& port) const { return folder.path() / "world" / port; }

  test::TempFolder folder;
  std::optional<Link> far, near;
  std::optional<PortTunnel> drivers, instruments;
};

/// A socket of this test.
struct End {
  explicit End(int descriptor = -1) : fd(descriptor) {}
  ~End() { close(); }
  End(const End&) = delete;
  void close() {
    if (fd >= 0) ::close(fd);
    fd = -1;
  }
  void say(const std::string& text) {
    REQUIRE(::send(fd, text.data(), text.size(), MSG_NOSIGNAL) == ssize_t(text.size()));
  }
  /// Adds what has come; sets `ended` at the end.
  void hear() {
    char bytes[4096];
    for (ssize_t got = 0; (got = ::recv(fd, bytes, sizeof bytes, MSG_DONTWAIT)) >= 0;) {
      if (got == 0) {
        ended = true;
        return;
      }
      heard.append(bytes, std::size_t(got));
    }
  }
  int fd;
  std::string heard;
  bool ended = false;
};

int dial(const std::filesystem::path& path) {
  const SocketAddress address(path);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  REQUIRE(::connect(fd, address.get(), sizeof(sockaddr_un)) == 0);
  return fd;
}

/// The world's listening socket.
struct World {
  explicit World(const std::filesystem::path& path)
      : listener(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    const SocketAddress address(path);
    REQUIRE(::bind(listener.fd, address.get(), sizeof(sockaddr_un)) == 0);
    REQUIRE(::listen(listener.fd, 4) == 0);
  }
  int accept() const { return ::accept4(listener.fd, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC); }
  End listener;
};

std::string noise(std::mt19937& random, std::size_t most) {
  std::string text(1 + random() % most, ' ');
  for (char& c : text) c = char(random());
  return text;
}

}  // namespace

TEST_CASE("bytes of a simulated instrument cross the line as they went in, by one lane or several",
          "[relay]") {
  const int lanes = GENERATE(0, 2);
  const std::string port = GENERATE(as<std::string>(), "jet", "laser_profiler");
  Tunnelled t(lanes);
  const World world(t.world_port(port));
  End driver(dial(t.driver_port(port))), instrument;
  t.until([&] { return (instrument.fd = world.accept()) >= 0; });
  std::mt19937 random(3);
  std::string down, up;
  for (int n = 0; n < 200; ++n) {
    const std::string order = noise(random, 300), answer = noise(random, 5000);
    driver.say(order);
    instrument.say(answer);
    down += order;
    up += answer;
    for (unsigned turns = random() % 4; turns > 0; --turns) t.turn();
    driver.hear();
  }
  t.until([&] {
    driver.hear();
    instrument.hear();
    return driver.heard.size() >= up.size() && instrument.heard.size() >= down.size();
  });
  CHECK(driver.heard == up);
  CHECK(instrument.heard == down);
}

TEST_CASE("the end of either side of a tunnelled port is the other's, behind its last bytes", "[relay]") {
  const bool by_driver = GENERATE(true, false);
  Tunnelled t(2);
  const World world(t.world_port("jet"));
  End driver(dial(t.driver_port("jet"))), instrument;
  t.until([&] { return (instrument.fd = world.accept()) >= 0; });
  End& first = by_driver ? driver : instrument;
  End& other = by_driver ? instrument : driver;
  first.say("off");
  first.close();
  t.until([&] {
    other.hear();
    return other.ended;
  });
  CHECK(other.heard == "off");
}

TEST_CASE("a driver that opens its tunnelled port again speaks to its instrument anew", "[relay]") {
  Tunnelled t(2);
  const World world(t.world_port("jet"));
  for (const std::string word : {"first", "second", "third"}) {
    End driver(dial(t.driver_port("jet"))), instrument;
    t.until([&] { return (instrument.fd = world.accept()) >= 0; });
    driver.say(word);
    t.until([&] {
      instrument.hear();
      return !instrument.heard.empty();
    });
    CHECK(instrument.heard == word);
  }
}

TEST_CASE("a tunnelled port behind which no world is ends the driver's connection", "[relay]") {
  Tunnelled t;
  End driver(dial(t.driver_port("jet")));
  t.until([&] {
    driver.hear();
    return driver.ended;
  });
  CHECK(driver.heard.empty());
}

TEST_CASE("the end of the relay is the loss of each simulated instrument's cable", "[relay]") {
  Tunnelled t;
  const World world(t.world_port("jet"));
  const End driver(dial(t.driver_port("jet")));
  End instrument;
  t.until([&] { return (instrument.fd = world.accept()) >= 0; });
  t.instruments.reset();
  instrument.hear();
  CHECK(instrument.ended);
}

TEST_CASE("frames of ports that are not there are passed over", "[relay]") {
  Tunnelled t;
  const std::string text = "x";
  const auto bytes = std::as_bytes(std::span(text));
  for (const Frame& f :
       {Frame{FrameKind::kPort, "lamp", 1, 1, bytes}, Frame{FrameKind::kPort, "jet", 7, 1, bytes},
        Frame{FrameKind::kPort, "jet", 1, 9, bytes}})
    CHECK_NOTHROW(t.drivers->take(f));
}

TEST_CASE("a driver that reads nothing holds up its instrument, and no memory grows", "[relay]") {
  Tunnelled t;
  const World world(t.world_port("laser_profiler"));
  const End driver(dial(t.driver_port("laser_profiler")));
  End instrument;
  t.until([&] { return (instrument.fd = world.accept()) >= 0; });
  const std::string much(64 << 10, 'r');
  std::size_t taken = 0;
  for (int n = 0; n < 5000; ++n) {
    const ssize_t put = ::send(instrument.fd, much.data(), much.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (put > 0) taken += std::size_t(put);
    t.turn();
    if (put < 0 && errno == EPIPE) break;
  }
  CHECK(taken < (std::size_t(32) << 20));
}
