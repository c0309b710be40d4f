#include "print/live/bus_check.h"

#include <poll.h>

#include <exception>

#include "print/process/bus_port.h"
#include "procs/bus/lcm_bus.h"
#include "runtime/run_clock.h"

namespace firn {

std::string check_multicast(double within_s) {
  static constexpr const char* kMend =
      "multicast has no route on loopback; mend: ip link set lo multicast on; ip route add 224.0.0.0/4 dev "
      "lo";
  try {
    LcmBus bus(default_bus_url(free_bus_port(monotonic_ns())), BusKey::random());
    bus.subscribe("FIRN_DOCTOR");
    const std::byte probe[8]{};
    bool heard = false;
    const std::int64_t until = monotonic_us() + std::int64_t(within_s * 1e6);
    while (!heard && monotonic_us() < until) {
      bus.publish("FIRN_DOCTOR", probe);
      pollfd p{bus.fd(), POLLIN, 0};
      ::poll(&p, 1, 50);
      bus.receive([&](std::string_view, std::span<const std::byte>) { heard = true; });
    }
    if (heard) return {};
    return std::string("a datagram to the bus did not come back: ").append(kMend);
  } catch (const std::exception& e) {
    return std::string(e.what()) + "; " + kMend;
  }
}

}  // namespace firn
