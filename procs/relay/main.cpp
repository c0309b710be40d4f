// Runs the process `relay`, one for each host of a run: see procs/relay/near_end.h.
#include <csignal>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include <poll.h>

#include "procs/bus/bus_key.h"
#include "procs/bus/lcm_bus.h"
#include "procs/relay/near_end.h"
#include "runtime/precedence.h"
#include "runtime/process_args.h"

namespace {

// The launcher's order is the first line behind the key.
firn::relay::HostOrder take_order(firn::ControlLine& control) {
  for (int n = 0; n < 100; ++n) {
    if (const auto line = control.next()) return firn::relay::order_from_json(*line);
    pollfd p{control.fd(), POLLIN, 0};
    ::poll(&p, 1, 100);
  }
  throw std::runtime_error("no order came by the control line");
}

}  // namespace

int main(int argc, char** argv) try {
  const firn::Precedence precedence;  // leases and stops pass through it
  for (const int ignored : {SIGINT, SIGHUP, SIGPIPE, SIGXFSZ}) std::signal(ignored, SIG_IGN);
  const firn::ProcessArgs args = firn::parse_process_args({argv + 1, argv + argc});
  std::optional<firn::LcmBus> bus;
  std::string key_line;
  if (args.bus_url != "-") {  // else it only collects
    const auto key = firn::take_bus_key(args);
    if (!key) throw std::runtime_error("a run with other hosts has no bus with key=none");
    key_line = key->line();
    bus.emplace(args.bus_url, key);
    bus->subscribe_all();
  }
  firn::ControlLine control(args.options.control_fd);
  firn::relay::HostOrder order = take_order(control);
  return firn::relay::NearEnd(std::move(order), key_line, args.options.run_dir, bus ? &*bus : nullptr,
                              control)
      .run();
} catch (const std::exception& e) {
  std::fprintf(stderr, "relay: %s\n", e.what());
  return 2;
}
