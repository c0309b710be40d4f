// The bus in a network namespace of its own, with an interface besides lo on which a foreign host sends.
#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstring>

#include "procs/bus/lcm_bus.h"
#include "tests/procs/foreigner.h"
#include "tests/support/skip.h"

using namespace firn;
using namespace firn::test;

namespace {

constexpr int kPort = 21500;
constexpr in_addr_t kOwn = 0x0A090001, kForeign = 0x0A090002, kGroup = 0xEFFF4C43;  // 239.255.76.67

enum Verdict { kSilent = 0, kNotPermitted, kNoInterface, kControlDeaf, kHeard, kOwnLost };

bool set_up(const char* name, in_addr_t address) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  ifreq r{};
  std::strncpy(r.ifr_name, name, IFNAMSIZ - 1);
  sockaddr_in a{};
  a.sin_family = AF_INET;
  bool good = true;
  if (address) {
    a.sin_addr.s_addr = htonl(address);
    std::memcpy(&r.ifr_addr, &a, sizeof a);
    good = ::ioctl(fd, SIOCSIFADDR, &r) == 0;
    a.sin_addr.s_addr = htonl(0xFFFFFF00);
    std::memcpy(&r.ifr_netmask, &a, sizeof a);
    good = good && ::ioctl(fd, SIOCSIFNETMASK, &r) == 0;
  }
  r.ifr_flags = IFF_UP | IFF_RUNNING | IFF_MULTICAST;
  good = good && ::ioctl(fd, SIOCSIFFLAGS, &r) == 0;
  ::close(fd);
  return good;
}

/// An interface whose other end is the returned descriptor.
int make_interface() {
  const int fd = ::open("/dev/net/tun", O_RDWR);
  ifreq r{};
  r.ifr_flags = IFF_TUN | IFF_NO_PI;
  std::strncpy(r.ifr_name, "other", IFNAMSIZ - 1);
  if (fd < 0 || ::ioctl(fd, TUNSETIFF, &r) != 0 || !set_up("other", kOwn)) return -1;
  return fd;
}

/// A datagram of the foreign host comes in.
void come_in(int interface, in_addr_t to, const Bytes& payload) {
  iphdr ip{};
  ip.version = 4;
  ip.ihl = 5;
  ip.ttl = 1;
  ip.protocol = IPPROTO_UDP;
  ip.tot_len = htons(std::uint16_t(sizeof ip + sizeof(udphdr) + payload.size()));
  ip.saddr = htonl(kForeign);
  ip.daddr = htonl(to);
  std::uint16_t words[10];
  std::memcpy(words, &ip, sizeof ip);
  std::uint32_t sum = 0;
  for (const std::uint16_t w : words) sum += w;
  while (sum >> 16) sum = (sum & 0xffff) + (sum >> 16);
  ip.check = std::uint16_t(~sum);
  udphdr udp{};
  udp.source = htons(4000);
  udp.dest = htons(kPort);
  udp.len = htons(std::uint16_t(sizeof udp + payload.size()));
  Bytes packet(sizeof ip + sizeof udp);
  std::memcpy(packet.data(), &ip, sizeof ip);
  std::memcpy(packet.data() + sizeof ip, &udp, sizeof udp);
  packet.insert(packet.end(), payload.begin(), payload.end());
  (void)!::write(interface, packet.data(), packet.size());
}

/// A receiver as LCM's: any interface that the group was joined on, any address of this host.
int open_receiver() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_port = htons(kPort);
  ::bind(fd, reinterpret_cast<const sockaddr*>(&any), sizeof any);
  ip_mreqn join{};
  join.imr_multiaddr.s_addr = htonl(kGroup);
  join.imr_ifindex = int(::if_nametoindex("other"));
  ::setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join);
  return fd;
}

int heard_by(int fd) {
  int n = 0;
  char b[2048];
  for (pollfd p{fd, POLLIN, 0}; ::poll(&p, 1, 200) > 0; ++n) (void)!::recv(fd, b, sizeof b, 0);
  return n;
}

Verdict attack() {
  if (::unshare(CLONE_NEWNET) != 0) return kNotPermitted;
  if (!set_up("lo", 0)) return kNoInterface;
  const int interface = make_interface();
  if (interface < 0) return kNoInterface;
  LcmBus bus("udpm://239.255.76.67:" + std::to_string(kPort) + "?ttl=0&key=none");
  bus.subscribe("MAP");
  const int control = open_receiver();
  for (int n = 0; n < 5; ++n) come_in(interface, kGroup, short_message("MAP", "from outside"));
  for (int n = 0; n < 5; ++n) come_in(interface, kOwn, short_message("MAP", "to the host"));
  if (heard_by(control) != 10) return kControlDeaf;
  int foreign = 0, own = 0;
  const auto receive = [&] {
    bus.receive([&](std::string_view, std::span<const std::byte> b) { ++(b.size() == 3 ? own : foreign); });
  };
  receive();
  bus.publish("MAP", std::as_bytes(std::span("own").first(3)));
  for (int n = 0; n < 20 && own == 0; ++n) {
    pollfd p{bus.fd(), POLLIN, 0};
    ::poll(&p, 1, 100);
    receive();
  }
  char out[2048];  // whatever left by the other interface: none of it is UDP
  ::fcntl(interface, F_SETFL, O_NONBLOCK);
  while (::read(interface, out, sizeof out) > 0)
    if (out[0] >> 4 == 4 && out[9] == IPPROTO_UDP) return kHeard;
  return foreign > 0 || !bus.dropped_text().empty() ? kHeard : own == 1 ? kSilent : kOwnLost;
}

}  // namespace

TEST_CASE("what comes in by another interface than lo is not heard, and nothing leaves by it") {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) ::_exit(attack());
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  if (WEXITSTATUS(status) == kNotPermitted || WEXITSTATUS(status) == kNoInterface) {
    skip("network-namespace", "a network namespace, or /dev/net/tun in it, is not permitted here");
    return;
  }
  CHECK(WEXITSTATUS(status) == kSilent);
}
