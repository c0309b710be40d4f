#include "runtime/wall_clock_ports.h"

#include <poll.h>

#include <algorithm>
#include <stdexcept>

#include "runtime/run_clock.h"

namespace firn {
namespace {

constexpr std::int64_t kLook_us = 1000, kOpenWithin_us = 3'000'000;

std::vector<PortAddress> in_order(const std::map<std::string, PortAddress>& addresses) {
  std::vector<PortAddress> all;
  for (const auto& [name, address] : addresses) all.push_back(address);
  return all;
}

}  // namespace

WallClockPorts::WallClockPorts(const std::map<std::string, PortAddress>& addresses)
    : ports_(in_order(addresses)), open_(addresses.size(), false), began_us_(monotonic_us()) {
  for (const auto& [name, address] : addresses) names_.push_back(name);
}

std::size_t WallClockPorts::index_of(std::string_view port) const {
  const auto at = std::ranges::find(names_, port);
  if (at == names_.end()) throw std::invalid_argument("there is no port '" + std::string(port) + "'");
  return std::size_t(at - names_.begin());
}

std::int64_t WallClockPorts::lab_us() const { return monotonic_us() - began_us_; }

void WallClockPorts::connect(std::string_view port, Time) {
  const std::size_t n = index_of(port);
  ports_.reopen(PortId(n), monotonic_us());
  const std::int64_t until_us = monotonic_us() + kOpenWithin_us;
  while (!open_[n] && monotonic_us() < until_us) listen(kLook_us);
  if (!open_[n]) heard_.push_back({n, {}, true});
}

void WallClockPorts::disconnect(std::string_view port, Time) {
  const std::size_t n = index_of(port);
  open_[n] = false;
  ports_.reopen(PortId(n), INT64_MAX);
}

void WallClockPorts::receive(std::string_view port, std::span<const std::byte> bytes, Time) {
  ports_.write(PortId(index_of(port)), bytes, false);
}

Time WallClockPorts::next_event() const { return Time{lab_us() + (heard_.empty() ? kLook_us : 0)}; }

void WallClockPorts::listen(std::int64_t max_us) {
  std::vector<pollfd> fds;
  ports_.add_to(fds);
  const timespec timeout{0, long(std::clamp<std::int64_t>(max_us, 0, 100'000)) * 1000};
  ::ppoll(fds.data(), fds.size(), &timeout, nullptr);
  ports_.service(
      monotonic_us(),
      [this](PortId id, LinkState link) {
        const auto n = std::size_t(id);
        open_[n] = link == LinkState::kOpen;
        if (!open_[n]) heard_.push_back({n, {}, true});
      },
      [this](PortId id, std::span<const std::byte> bytes) {
        heard_.push_back({std::size_t(id), {bytes.begin(), bytes.end()}, false});
      });
}

void WallClockPorts::advance(Time now, const Send& send) {
  do listen(now.us - lab_us());
  while (heard_.empty() && lab_us() < now.us);
  const std::vector<Heard> heard = std::move(heard_);
  heard_.clear();
  for (const Heard& h : heard) send(names_[h.port], h.bytes, now, h.close);
}

}  // namespace firn
