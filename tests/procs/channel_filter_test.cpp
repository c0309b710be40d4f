// The kernel's filter of channels, against the reader of packets: what passes a socket of this machine.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "core/grid/random.h"
#include "print/process/bus_port.h"
#include "procs/bus/channel_filter.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/run_clock.h"
#include "tests/procs/foreigner.h"

using namespace firn;
using namespace firn::test;

namespace {

using Channels = std::set<std::string, std::less<>>;

/// Two UDP sockets on 127.0.0.1, one of them behind the filter.
class Filtered {
 public:
  explicit Filtered(const Channels& channels) {
    const in_addr here{htonl(INADDR_LOOPBACK)};
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr = here;
    socklen_t size = sizeof at_;
    REQUIRE(::bind(in_, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0);
    REQUIRE(::getsockname(in_, reinterpret_cast<sockaddr*>(&at_), &size) == 0);
    std::vector<sock_filter> program = channel_filter(channels);
    const sock_fprog filter{std::uint16_t(program.size()), program.data()};
    REQUIRE(::setsockopt(in_, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0);
  }
  ~Filtered() {
    ::close(in_);
    ::close(out_);
  }
  Filtered(const Filtered&) = delete;
  Filtered& operator=(const Filtered&) = delete;

  bool passes(const Bytes& datagram) {
    REQUIRE(::sendto(out_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&at_),
                     sizeof at_) >= 0);
    std::byte buffer[2000];
    return ::recv(in_, buffer, sizeof buffer, MSG_DONTWAIT) >=
           0;  // loopback delivers before sendto() returns
  }

 private:
  int in_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0),
      out_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in at_{};
};

std::string drawn_name(RandomStream& random, std::uint32_t longest) {
  std::string name;  // few letters, so that names begin alike
  for (std::uint32_t left = 1 + random.below(longest); left > 0; --left) name += char('A' + random.below(2));
  return name;
}

}  // namespace

TEST_CASE(
    "the kernel drops whole messages of other channels, and passes those of its own and all that is "
    "damaged") {
  RandomStream random(7, Purpose::kTest);
  int dropped = 0, passed = 0;
  for (int round = 0; round < 20; ++round) {
    Channels channels;
    for (std::uint32_t n = random.below(40); n > 0; --n) channels.insert(drawn_name(random, n % 2 ? 63 : 9));
    Filtered socket(channels);
    for (int n = 0; n < 100; ++n) {
      const bool own = !channels.empty() && random.below(2) == 0;
      std::string name =
          own ? *std::next(channels.begin(), std::ptrdiff_t(random.below(std::uint32_t(channels.size()))))
              : drawn_name(random, 70);
      Bytes datagram = short_message(name, std::string(random.below(200), 'x'));
      if (random.below(8) == 0) datagram[random.below(12)] ^= std::byte(1 + random.below(255));
      if (random.below(8) == 0) datagram.resize(random.below(std::uint32_t(datagram.size()) + 1));
      const LcmPacket p = read_packet(datagram);
      const bool other = datagram.size() >= kShortestFiltered && p.fault == PacketFault::kNone &&
                         !channels.contains(p.channel);
      CAPTURE(round, n, name, datagram.size(), word(p.fault));
      REQUIRE(socket.passes(datagram) == !other);
      ++(other ? dropped : passed);
    }
  }
  CHECK(dropped > 300);
  CHECK(passed > 300);
}

TEST_CASE("a program that is too long for the kernel is none") {
  Channels channels;
  for (int n = 0; n < 200; ++n) channels.insert(std::string(60, 'x') + std::to_string(100 + n));
  CHECK(channel_filter(channels).empty());
}

TEST_CASE("a bus sleeps through messages of other channels, and subscribes to more of them at any time") {
  const int port = free_bus_port(monotonic_ns());
  LcmBus bus(default_bus_url(port) + "&key=none");
  Foreigner foreigner(port);
  bus.subscribe("MAP");
  const auto wakes = [&](const std::string& channel) {
    foreigner.to_group(short_message(channel, std::string(100, 'x')));
    pollfd p{bus.fd(), POLLIN, 0};
    return ::poll(&p, 1, 0) > 0;
  };
  CHECK_FALSE(wakes("HEARTBEAT_JET"));
  bus.subscribe("HEARTBEAT_JET");
  CHECK(wakes("HEARTBEAT_JET"));
  for (int n = 0; n < 200; ++n) bus.subscribe(std::string(55, 'x') + std::to_string(n));
  CHECK(wakes("HEARTBEAT_JET"));
}
