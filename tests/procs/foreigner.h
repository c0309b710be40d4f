// Foreigner is a program of this host that is not Firn and sends datagrams to the bus; with the forms of
// LCM's datagrams.
#pragma once

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

namespace firn::test {

using Bytes = std::vector<std::byte>;

inline void put32(Bytes& b, std::uint32_t v) {
  for (int k = 24; k >= 0; k -= 8) b.push_back(std::byte(v >> k));
}
inline void put16(Bytes& b, std::uint16_t v) {
  b.push_back(std::byte(v >> 8));
  b.push_back(std::byte(v));
}
inline void put_text(Bytes& b, std::string_view s) {
  for (const char c : s) b.push_back(std::byte(c));
}

inline Bytes short_message(std::string_view channel, std::string_view payload) {
  Bytes b;
  put32(b, 0x4c433032);
  put32(b, 7);
  put_text(b, channel);
  b.push_back(std::byte{0});
  put_text(b, payload);
  return b;
}

inline Bytes fragment(std::uint32_t size, std::uint32_t offset, std::uint16_t number, std::uint16_t of,
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

/// Datagrams that ended every receiver of liblcm, and others of their kind: fragments whose offset wraps or
/// whose channel has no end, short messages without an end of their channel.
inline std::vector<Bytes> malformed_datagrams() {
  Bytes no_end = short_message("ENABLE", "");
  no_end.pop_back();
  Bytes other = short_message("ENABLE", "x");
  other[0] = std::byte{0};
  return {fragment(100, 0, 0, 2, std::string_view("ENABLE\0abc", 10)),
          fragment(100, 0xfffffff0u, 1, 2, std::string_view("0123456789012345678901234567890123456789")),
          fragment(4, 0, 0, 1, "no end here"),
          fragment(0xffffffffu, 0xffffffffu, 65535, 65535, ""),
          no_end,
          short_message(std::string_view("0123456789012345678901234567890123456789012345678901234567890123"),
                        "x"),
          other,
          Bytes(9),
          {}};
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
  /// To every address that this host has.
  void to_this_host(const Bytes& b) {
    ifaddrs* all = nullptr;
    if (::getifaddrs(&all) != 0) return;
    for (const ifaddrs* a = all; a; a = a->ifa_next) {
      if (!a->ifa_addr || a->ifa_addr->sa_family != AF_INET) continue;
      sockaddr_in address;
      std::memcpy(&address, a->ifa_addr, sizeof address);
      send(b, address.sin_addr);
    }
    ::freeifaddrs(all);
  }

 private:
  int fd_;
  int port_;
};

}  // namespace firn::test
