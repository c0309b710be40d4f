#include "cli/bus_port.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

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

}  // namespace firn
