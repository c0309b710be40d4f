#include "runtime/relay/peer_clock.h"

#include <algorithm>

namespace firn::relay {

void PeerClock::add(std::int64_t sent_ns, std::int64_t told_ns, std::int64_t received_ns) {
  if (received_ns < sent_ns) return;
  trips_.push_back({sent_ns, told_ns, received_ns});
  while (trips_.front().received_ns < received_ns - kKeptNs) trips_.pop_front();
}

std::optional<PeerClock::Estimate> PeerClock::at(std::int64_t now_ns) const {
  if (trips_.empty()) return std::nullopt;
  const std::int64_t origin = trips_.back().told_ns - trips_.back().received_ns;  // keeps the doubles exact
  std::optional<Estimate> estimate;
  double low = 0.0, high = 0.0;
  std::int64_t quickest = INT64_MAX;
  for (auto trip = trips_.rbegin(); trip != trips_.rend(); ++trip) {
    const double drift = kMostDrift * double(std::max<std::int64_t>(now_ns - trip->sent_ns, 0));
    const double from = double(trip->told_ns - trip->received_ns - origin) - drift;
    const double to = double(trip->told_ns - trip->sent_ns - origin) + drift;
    const bool first = trip == trips_.rbegin();
    if (!first && (from > high || to < low)) break;
    low = first ? from : std::max(low, from);
    high = first ? to : std::min(high, to);
    quickest = std::min(quickest, trip->received_ns - trip->sent_ns);
  }
  return Estimate{origin + std::int64_t((low + high) / 2.0), std::int64_t((high - low) / 2.0), quickest};
}

}  // namespace firn::relay
