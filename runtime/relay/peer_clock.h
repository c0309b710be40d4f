// PeerClock bounds the difference between this computer's clock and another's from round trips [Mills, RFC
// 5905, section 8]: the answer was given between question and arrival, whatever the way takes.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace firn::relay {

class PeerClock {
 public:
  /// The difference lies within `ahead_ns` +- `bound_ns`.
  struct Estimate {
    std::int64_t ahead_ns = 0;  ///< of the other clock
    std::int64_t bound_ns = 0;
    std::int64_t quickest_ns = 0;  ///< round trip of those that count
  };

  /// One round trip, all in [ns]: `sent` and `received` by this clock, `told` by the other one.
  void add(std::int64_t sent_ns, std::int64_t told_ns, std::int64_t received_ns);
  /// Intersects the intervals of the round trips of the last kKeptNs, each wider by kMostDrift for its age.
  /// If they contradict each other, as after a clock has leapt, the newest alone counts. Nothing before the
  /// first.
  std::optional<Estimate> at(std::int64_t now_ns) const;

  static constexpr double kMostDrift = 500e-6;  ///< of one clock against the other
  static constexpr std::int64_t kKeptNs = 5'000'000'000;

 private:
  struct Trip {
    std::int64_t sent_ns, told_ns, received_ns;
  };
  std::deque<Trip> trips_;
};

}  // namespace firn::relay
