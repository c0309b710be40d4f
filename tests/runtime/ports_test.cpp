// Bytes of a command leave a port while the lease holds, and not later.
#include "runtime/ports.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "tests/support/temp_folder.h"

using namespace firn;

namespace {

/// An instrument that reads nothing until it is asked to.
struct Silent {
  explicit Silent(const std::filesystem::path& path) {
    listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un a{};
    a.sun_family = AF_UNIX;
    path.string().copy(a.sun_path, sizeof a.sun_path - 1);
    REQUIRE(::bind(listener, reinterpret_cast<sockaddr*>(&a), sizeof a) == 0);
    REQUIRE(::listen(listener, 4) == 0);
  }
  ~Silent() {
    ::close(fd);
    ::close(listener);
  }
  void accept() { fd = ::accept4(listener, nullptr, nullptr, SOCK_NONBLOCK); }
  std::string read() const {
    std::string all;
    char b[4096];
    for (ssize_t got; (got = ::recv(fd, b, sizeof b, 0)) > 0;) all.append(b, std::size_t(got));
    return all;
  }
  int listener = -1, fd = -1;
};

struct PortsBench {
  test::TempFolder folder;
  Silent instrument{folder.path() / "valve"};
  std::string loss;
  Ports ports{{unix_port((folder.path() / "valve").string())}, [this] { return loss; }};
  std::vector<LinkState> links;
  std::vector<std::string> refused;

  PortsBench() {
    ports.open_all(0);
    service();
    instrument.accept();
    REQUIRE(links == std::vector{LinkState::kOpen});
  }
  void service() {
    ports.service(
        0, [&](PortId, LinkState s) { links.push_back(s); }, [](PortId, auto) {});
    ports.take_refused([&](PortId, const std::string& cause) { refused.push_back(cause); });
  }
  void write(const std::string& text, bool of_command) {
    ports.write(PortId{0}, std::as_bytes(std::span(text)), of_command);
  }
};

}  // namespace

TEST_CASE("bytes of a command leave under a lease only, bytes that make safe always") {
  PortsBench b;
  b.write("FIRE 1\n", true);
  b.loss = "the lease has ended";
  b.write("FIRE 2\n", true);
  b.write("STOP\n", false);
  b.service();
  CHECK(b.instrument.read() == "FIRE 1\nSTOP\n");
  CHECK(b.refused == std::vector<std::string>{"the lease has ended"});
  b.service();
  CHECK(b.refused.size() == 1);  // told once
}

TEST_CASE("bytes of a command that wait for a slow instrument are dropped when the lease ends") {
  PortsBench b;
  b.write(std::string(1 << 20, 'x'), false);  // more than the kernel takes
  b.write("FIRE\n", true);
  b.write("STOP\n", false);
  b.loss = "the lease has ended";
  std::string all;
  for (int n = 0; n < 100; ++n) {
    all += b.instrument.read();
    b.service();
  }
  all += b.instrument.read();
  CHECK(all.find("FIRE") == std::string::npos);
  CHECK(all.ends_with("xSTOP\n"));
  CHECK(b.refused.size() == 1);
  CHECK(b.links.size() == 1);
}

TEST_CASE("a command of which a part has left is cut by closing the link, so that a stop begins a new line") {
  PortsBench b;
  b.write(std::string(1 << 20, 'F'), true);
  b.loss = "the lease has ended";
  b.write("STOP\n", false);
  const std::size_t part = b.instrument.read().size();
  CHECK(part < (1 << 20));
  b.service();
  CHECK(b.refused.size() == 1);
  REQUIRE(b.links.size() >= 2);
  CHECK(b.links[1] == LinkState::kClosed);
  CHECK(b.instrument.read().empty());
}

TEST_CASE("an instrument that babbles is read a piece a turn, and its link is lost by name") {
  test::TempFolder folder;
  Silent instrument(folder.path() / "lamp");
  Ports ports({unix_port((folder.path() / "lamp").string())}, {}, {port_rate("lamp")});
  std::int64_t now_us = 1;
  std::size_t total = 0, most = 0;
  std::vector<LinkState> links;
  const auto turn = [&] {
    std::size_t came = 0;
    ports.service(
        now_us += 1000, [&](PortId, LinkState s) { links.push_back(s); },
        [&](PortId, std::span<const std::byte> b) { came += b.size(); });
    total += came;
    most = std::max(most, came);
  };
  ports.open_all(0);
  turn();
  instrument.accept();
  const std::string babble(1 << 16, 'b');
  for (int n = 0; n < 1000 && links.back() == LinkState::kOpen; ++n) {
    for (int piece = 0; piece < 8; ++piece)
      (void)::send(instrument.fd, babble.data(), babble.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    turn();
  }
  CHECK(links == std::vector{LinkState::kOpen, LinkState::kClosed});
  CHECK(most <= Ports::kReadPerTurn);
  CHECK(double(total) <= RateMeter::kLeastHeld_bytes + port_rate("lamp").bytes_per_s * double(now_us) * 1e-6);
  const auto notices = ports.take_notices();
  REQUIRE(notices.size() == 1);
  CHECK(notices[0] ==
        "unix:" + (folder.path() / "lamp").string() +
            ": more than the 7680 bytes/s came that its instrument can send: the link is closed");
}
