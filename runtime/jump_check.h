// JumpCheck holds the greatest numbers that came on each channel, and refuses a message whose numbers cannot
// follow them: such a message is not the run's own, and one that is taken would end every later resume.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "lcmtypes/channels.h"
#include "runtime/transport_wire.h"

namespace firn {

/// Safety raises the epoch once at each start and once for the stop of that start.
constexpr std::int64_t largest_epoch(std::int32_t incarnation) { return 2 * (std::int64_t(incarnation) + 1); }

/// Layers between two messages of a channel: the bound of ice.interval_layers. An ink-jet print has 1.
inline constexpr std::int64_t kMaxLayersAtOnce = 100;
/// Scans or maps between two messages of a channel: those that gave none.
inline constexpr std::int64_t kMaxScansAtOnce = 1000;

class JumpCheck {
 public:
  /// Returns an empty text and remembers the numbers, or one sentence that names member, value and limit.
  /// Checked are the epoch of ENABLE, SAFE_STOP, commands and states, layer and scan_id or map_id of maps,
  /// plans, reports and measurements. A message that is too short or of another type has no numbers.
  std::string take(const ChannelInfo& channel, const wire::Header& header,
                   std::span<const std::byte> message);
  /// The same for a message that was taken by an earlier start; the first of a channel may have any layer.
  std::string restore(const ChannelInfo& channel, const wire::Header& header,
                      std::span<const std::byte> message);

 private:
  struct Last {
    std::int64_t layer = 0, number = 0;
  };
  std::string follow(const ChannelInfo& channel, const wire::Header& header,
                     std::span<const std::byte> message, bool any_first);

  std::map<std::string_view, Last> last_;  // names of the channel table
};

}  // namespace firn
