// The real ports of a lab that do not open before a print.
#include <unistd.h>

#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include "config/devices.h"
#include "print/bringup/bringup.h"
#include "print/hosts/at_host.h"
#include "runtime/port_wire.h"
#include "runtime/run_clock.h"

namespace firn {
namespace {

/// A port is tried again for so long: whoever held it may just have ended.
constexpr std::int64_t kTryFor_us = 1'500'000;
constexpr std::int64_t kBetweenTries_us = 100'000;
constexpr useconds_t kLook_us = 10'000;

/// One real port, opened again and again until it answers or its time is over.
class TriedPort {
 public:
  TriedPort(std::string node, const PortAddress& address) : node_(std::move(node)) {
    try {
      wire_.emplace(address);
    } catch (const std::exception& error) {  // its host is not known, its cassette cannot be read
      trouble_ = error.what();
    }
  }

  /// Tries once more. @param last the time is over @returns whether it is known if the port opens
  bool turn(std::int64_t now_us, bool last) {
    if (opens_ || !wire_) return true;
    if (wire_->state() == PortWire::State::kClosed && now_us >= again_us_) wire_->open(now_us);
    const PortWire::State state = wire_->settle(now_us);
    // A serial line that is given time to wake up is there already.
    const bool waits = state == PortWire::State::kConnecting;
    opens_ =
        state == PortWire::State::kOpen || (waits && wire_->address().kind == PortAddress::Kind::kSerial);
    if (opens_) wire_->close();
    if (opens_ || waits) return opens_;
    if (again_us_ <= now_us) again_us_ = now_us + kBetweenTries_us;
    trouble_ = wire_->trouble();
    return last;
  }

  /// Returns node, address and cause; empty: it opens.
  std::string refusal() const { return opens_ ? std::string() : node_ + " at " + trouble_; }

 private:
  std::string node_, trouble_;
  std::optional<PortWire> wire_;  ///< none where the address leads nowhere
  bool opens_ = false;
  std::int64_t again_us_ = 0;
};

}  // namespace

std::string closed_ports(const Experiment& experiment) {
  std::vector<TriedPort> tried;
  for (const auto& [node, address] : real_ports(experiment))
    // A class in Python opens its own, and tells why not when it is asked.
    if (host_of(experiment, node).empty() && address.kind != PortAddress::Kind::kPython)
      tried.emplace_back(node, address);
  const std::int64_t until_us = monotonic_us() + kTryFor_us;
  const auto all_known = [&] {
    bool known = true;
    for (TriedPort& port : tried) {
      const std::int64_t now_us = monotonic_us();
      known = port.turn(now_us, now_us >= until_us) && known;
    }
    return known;
  };
  while (!all_known()) ::usleep(kLook_us);
  std::string why;
  for (const TriedPort& port : tried)
    if (const std::string refusal = port.refusal(); !refusal.empty())
      why += (why.empty() ? "" : "; ") + refusal;
  return why;
}

}  // namespace firn
