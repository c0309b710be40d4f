// WallClockPorts: a Lab's world on real ports, against a socket that echoes.
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <thread>

#include "runtime/run_clock.h"
#include "runtime/wall_clock_ports.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using firn::test::TempFolder;

namespace {

// Answers each piece with itself until `say_no_more`.
class EchoSocket {
 public:
  explicit EchoSocket(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    listener_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::listen(listener_, 1) == 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~EchoSocket() {
    over_ = true;
    thread_.join();
    ::close(listener_);
  }

 private:
  void serve() {
    int client = -1;
    char bytes[256];
    while (!over_) {
      pollfd p{client < 0 ? listener_ : client, POLLIN, 0};
      if (::poll(&p, 1, 10) <= 0) continue;
      if (client < 0) {
        client = ::accept(listener_, nullptr, nullptr);
        continue;
      }
      const ssize_t n = ::read(client, bytes, sizeof bytes);
      if (n > 0 && bytes[0] != 'q') {
        if (::write(client, bytes, std::size_t(n)) < 0) break;
        continue;
      }
      ::close(client);
      client = -1;
    }
    if (client >= 0) ::close(client);
  }
  int listener_ = -1;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

struct Heard {
  std::string bytes;
  bool closed = false;
};

// Lets the clock go on until `done`, at most 5 s.
template <class Done>
bool wait_for(WallClockPorts& ports, Heard& heard, Done&& done) {
  const std::int64_t until_us = monotonic_us() + 5'000'000;
  while (!done() && monotonic_us() < until_us)
    ports.advance(ports.next_event(),
                  [&](std::string_view port, std::span<const std::byte> bytes, Time, bool close) {
                    CHECK(port == "echo");
                    heard.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                    heard.closed = heard.closed || close;
                  });
  return done();
}

}  // namespace

TEST_CASE("a lab on real ports hears what it is answered, in the clock's time, and the end of a link") {
  const TempFolder folder;
  const std::string path = (folder.path() / "echo").string();
  const EchoSocket echo(path);
  WallClockPorts ports({{"echo", unix_port(path)}});
  const std::int64_t began_us = monotonic_us();
  const Time before = ports.next_event();
  ports.connect("echo", before);
  ports.receive("echo", std::as_bytes(std::span("hello", 5)), before);
  Heard heard;
  CHECK(wait_for(ports, heard, [&] { return heard.bytes == "hello"; }));
  CHECK_FALSE(heard.closed);
  CHECK(std::abs(ports.next_event().us - before.us - (monotonic_us() - began_us)) < 50'000);
  ports.receive("echo", std::as_bytes(std::span("q", 1)), before);
  CHECK(wait_for(ports, heard, [&] { return heard.closed; }));
  heard = {};
  ports.connect("echo", ports.next_event());  // again
  ports.receive("echo", std::as_bytes(std::span("again", 5)), before);
  CHECK(wait_for(ports, heard, [&] { return heard.bytes == "again"; }));
}

TEST_CASE("a port that does not open is told as closed, and why") {
  WallClockPorts ports({{"echo", unix_port("/nowhere/echo")}});
  ports.connect("echo", Time{});
  Heard heard;
  CHECK(wait_for(ports, heard, [&] { return heard.closed; }));
  CHECK_THROWS_AS(ports.receive("lamp", {}, Time{}), std::invalid_argument);
}
