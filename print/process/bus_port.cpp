#include "print/process/bus_port.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>

#include "core/options/number.h"
#include "files/usage_error.h"

namespace firn {

bool bus_port_is_free(int port) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(std::uint16_t(port));
  // Without SO_REUSEADDR: refused when any other socket, also one that would share, has the port.
  const bool free = ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return free;
}

int free_bus_port(std::int64_t run_id) {
  const int first = int((std::uint64_t(run_id) * 0x9E3779B97F4A7C15ull >> 40) % kBusPorts);
  for (int n = 0; n < kBusPorts; ++n) {
    const int port = kFirstBusPort + (first + n) % kBusPorts;
    if (bus_port_is_free(port)) return port;
  }
  throw std::runtime_error("no free UDP port in " + std::to_string(kFirstBusPort) + " to " +
                           std::to_string(kFirstBusPort + kBusPorts - 1));
}

void check_bus(const std::string& bus) {
  constexpr std::string_view kScheme = "udpm://";
  if (bus.empty() || bus == "in-process") return;
  const auto refuse = [&](const std::string& what) {
    throw UsageError("--bus " + bus + ": " + what +
                     "; in-process or udpm://239.255.76.67:21000?ttl=0 is wanted");
  };
  if (!bus.starts_with(kScheme)) refuse("is no bus of several processes");
  const std::string place = bus.substr(kScheme.size(), bus.find('?') - kScheme.size());
  const std::size_t colon = place.find(':');
  if (colon == std::string::npos) refuse("has no port");
  in_addr address{};
  if (::inet_pton(AF_INET, place.substr(0, colon).c_str(), &address) != 1 ||
      !IN_MULTICAST(ntohl(address.s_addr)))
    refuse(place.substr(0, colon) + " is no multicast address (224.0.0.0 to 239.255.255.255)");
  const auto port = whole_number<std::int32_t>(std::string_view(place).substr(colon + 1));
  if (!port || *port < 1 || *port > 65535) refuse("the port must be a number in [1, 65535]");
}

}  // namespace firn
