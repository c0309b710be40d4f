// Lossy simulates a bad network: it loses, repeats, reorders and delays received datagrams, and counts
// them. Random numbers are keyed by (seed, node, incarnation), so that one node's luck does not depend on
// another's.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/grid/random.h"

namespace firn {

struct LossyOptions {  ///< probabilities per datagram
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;
  double delay = 0.0;
  double delay_s = 0.02;  ///< wall time, mean
  std::uint64_t seed = 0;
  std::uint32_t node = 0;
  std::uint32_t incarnation = 0;

  bool any() const { return loss > 0.0 || duplicate > 0.0 || reorder > 0.0 || delay > 0.0; }
};

struct LossyCounts {
  std::uint64_t passed = 0, lost = 0, duplicated = 0, reordered = 0, delayed = 0;
  std::uint64_t injected() const { return lost + duplicated + reordered + delayed; }
};

/// One line: "passed 10 lost 1 duplicated 0 reordered 2 delayed 0".
std::string to_text(const LossyCounts& counts);
/// @throws std::runtime_error if the text is not such a line
LossyCounts parse_lossy_counts(std::string_view text);

class Lossy {
 public:
  using Sink = std::function<void(std::string_view channel, std::span<const std::byte>)>;
  explicit Lossy(const LossyOptions& options);

  /// Hands the datagram on, or drops it, or keeps it for later.
  void receive(std::string_view channel, std::span<const std::byte> datagram, std::int64_t wall_us,
               const Sink& sink);
  /// Hands on the datagrams that were kept long enough.
  void release(std::int64_t wall_us, const Sink& sink);
  std::int64_t due_us() const;  ///< INT64_MAX = nothing is kept
  const LossyCounts& counts() const { return counts_; }

 private:
  struct Kept {
    std::string channel;
    std::vector<std::byte> bytes;
  };
  void keep(std::string_view channel, std::span<const std::byte> datagram, std::int64_t until_us);

  LossyOptions options_;
  RandomStream random_;
  std::multimap<std::int64_t, Kept> kept_;
  LossyCounts counts_;
};

}  // namespace firn
