// The bus under attack: datagrams that are none of ours, sent to the group and to this host.
#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "core/grid/random.h"
#include "print/live/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/run_clock.h"

using namespace firn;

namespace {

using Bytes = std::vector<std::byte>;

void put32(Bytes& b, std::uint32_t v) {
  for (int k = 24; k >= 0; k -= 8) b.push_back(std::byte(v >> k));
}
void put16(Bytes& b, std::uint16_t v) {
  b.push_back(std::byte(v >> 8));
  b.push_back(std::byte(v));
}
void put_text(Bytes& b, std::string_view s) {
  for (const char c : s) b.push_back(std::byte(c));
}

Bytes short_message(std::string_view channel, std::string_view payload) {
  Bytes b;
  put32(b, 0x4c433032);
  put32(b, 7);
  put_text(b, channel);
  b.push_back(std::byte{0});
  put_text(b, payload);
  return b;
}

Bytes fragment(std::uint32_t size, std::uint32_t offset, std::uint16_t number, std::uint16_t of,
               std::string_view body) {
  Bytes b;
  put32(b, 0x4c433033);
  put32(b, 1);
  put32(b, size);
  put32(b, offset);
  put16(b, number);
  put16(b, of);
  put_text(b, body);
  return b;
}

/// A program of this host that speaks to anybody.
class Foreigner {
 public:
  explicit Foreigner(int port) : fd_(::socket(AF_INET, SOCK_DGRAM, 0)), port_(port) {}
  ~Foreigner() { ::close(fd_); }
  void send(const Bytes& b, in_addr to) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_port = htons(std::uint16_t(port_));
    a.sin_addr = to;
    (void)::sendto(fd_, b.data(), b.size(), 0, reinterpret_cast<sockaddr*>(&a), sizeof a);
  }
  void to_group(const Bytes& b) {
    ip_mreqn by{};
    by.imr_ifindex = int(::if_nametoindex("lo"));
    ::setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &by, sizeof by);
    send(b, {::inet_addr("239.255.76.67")});
  }

 private:
  int fd_;
  int port_;
};

struct Bench {
  int port = free_bus_port(monotonic_ns());
  LcmBus bus{default_bus_url(port)};
  Foreigner foreigner{port};
  std::vector<std::pair<std::string, std::string>> heard;

  Bench() { bus.subscribe("MAP"); }
  /// Publishes a mark and receives until it comes back.
  void drain() {
    bus.subscribe("MARK");
    const std::byte mark{1};
    bus.publish("MARK", {&mark, 1});
    bool back = false;
    for (int n = 0; n < 200 && !back; ++n) {
      pollfd p{bus.fd(), POLLIN, 0};
      ::poll(&p, 1, 50);
      bus.receive([&](std::string_view channel, std::span<const std::byte> b) {
        if (channel == "MARK")
          back = true;
        else
          heard.emplace_back(channel, std::string(reinterpret_cast<const char*>(b.data()), b.size()));
      });
    }
    REQUIRE(back);
  }
};

}  // namespace

TEST_CASE(
    "a message of LCM's protocol arrives whole, an unsubscribed one does not, and an empty payload is one") {
  Bench b;
  b.foreigner.to_group(short_message("MAP", "bytes"));
  b.foreigner.to_group(short_message("OTHER", "bytes"));
  b.foreigner.to_group(short_message("MAP", ""));
  b.drain();
  CHECK(b.heard == std::vector<std::pair<std::string, std::string>>{{"MAP", "bytes"}, {"MAP", ""}});
  CHECK(b.bus.dropped_text().empty());
}

TEST_CASE("fragments whose offset wraps or whose channel has no end are dropped and counted") {
  Bench b;
  b.foreigner.to_group(fragment(100, 0, 0, 2, std::string("MAP\0abc", 7)));
  b.foreigner.to_group(fragment(100, 0xfffffff0u, 1, 2, std::string(64, 'x')));
  b.foreigner.to_group(fragment(4, 0, 0, 1, "no end here"));
  b.foreigner.to_group(fragment(0xffffffffu, 0xffffffffu, 65535, 65535, ""));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kFragment) == 4);
}

TEST_CASE("short packets without an end of their channel, with too long a channel or none are dropped") {
  Bench b;
  Bytes no_end = short_message("MAP", "");
  no_end.pop_back();
  b.foreigner.to_group(no_end);
  b.foreigner.to_group(short_message(std::string(64, 'M'), "x"));
  b.foreigner.to_group(short_message("", "x"));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kChannel) == 3);
}

TEST_CASE("whatever is no LCM is dropped, whatever its length") {
  Bench b;
  for (std::size_t n = 0; n < 10; ++n) b.foreigner.to_group(Bytes(n, std::byte{0x4c}));
  b.foreigner.to_group(Bytes(500, std::byte{0xff}));
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kShort) == 10);
  CHECK(b.bus.dropped(PacketFault::kForeign) == 1);
  CHECK(b.bus.dropped_text() == "11 foreign datagrams dropped (10 too short, 1 not LCM)");
}

TEST_CASE(
    "a datagram to an address of this host is not heard, and one to the group by another interface neither") {
  Bench b;
  ifaddrs* all = nullptr;
  REQUIRE(::getifaddrs(&all) == 0);
  for (const ifaddrs* a = all; a; a = a->ifa_next) {
    if (!a->ifa_addr || a->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address;
    std::memcpy(&address, a->ifa_addr, sizeof address);
    b.foreigner.send(short_message("MAP", "to the host"), address.sin_addr);
    b.foreigner.send(fragment(100, 0xfffffff0u, 1, 2, "x"), address.sin_addr);
  }
  ::freeifaddrs(all);
  b.drain();
  CHECK(b.heard.empty());
  CHECK(b.bus.dropped(PacketFault::kFragment) == 0);
}

TEST_CASE("random datagrams are read within their bounds, and what is a message is read as it was written") {
  RandomStream random(11, Purpose::kTest);
  int whole = 0;
  for (int n = 0; n < 20000; ++n) {
    const std::string channel(random.below(70), char('A' + random.below(26)));
    const std::string payload(random.below(40), 'p');
    Bytes b = short_message(channel, payload);
    if (random.below(2))
      for (std::uint32_t k = 1 + random.below(3); k > 0; --k)
        b[random.below(std::uint32_t(b.size()))] = std::byte(random.below(256));
    if (random.below(3) == 0) b.resize(random.below(std::uint32_t(b.size() + 1)));
    const Bytes exact(b.begin(), b.end());  // so that a sanitizer sees a read beyond it
    const LcmPacket p = read_packet(exact);
    if (p.fault != PacketFault::kNone) continue;
    ++whole;
    REQUIRE(p.channel.size() >= 1);
    REQUIRE(p.channel.size() <= 63);
    REQUIRE(8 + p.channel.size() + 1 + p.payload.size() == exact.size());
  }
  CHECK(whole > 4000);
}

TEST_CASE("the address of a bus is checked, and a datagram that would leave the host is refused") {
  for (const char* bad :
       {"udp://239.255.76.67:7667", "udpm://239.255.76.67", "udpm://10.0.0.1:7667", "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:7667?ttl=1", "udpm://239.255.76.67:7667?fifo=3"})
    CHECK_THROWS_WITH(LcmBus(bad), Catch::Contains(bad) && Catch::Contains("firn doctor"));
}

TEST_CASE("a message longer than a datagram of LCM is not sent as fragments but refused") {
  Bench b;
  CHECK_THROWS_AS(b.bus.publish("MAP", Bytes(65499 - 3)), std::logic_error);
  b.bus.publish("MAP", Bytes(65499 - 4));
  b.drain();
  REQUIRE(b.heard.size() == 1);
  CHECK(b.heard[0].second.size() == 65495);
}
