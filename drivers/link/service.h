// Service holds the order of a person to one instrument alone (firn device), beside the commands of a print:
// questions, or requests with an end that a stop sends at once.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/link/dialect.h"
#include "drivers/link/driver_event.h"

namespace firn::drivers {

/// Request::tag of a service's requests: no driver has it.
inline constexpr std::uint16_t kServiceTag = 0xFFFF;

/// True for a whole number of an order within [low, high].
inline bool whole_within(double value, double low, double high) {
  return value >= low && value <= high && value == std::floor(value);
}

struct Service {
  std::string verb;
  std::vector<Request> begin;
  std::int64_t hold_us = 0;  ///< between the replies to `begin` and the requests of `end`
  std::vector<Request> end;  ///< of an instrument that acts: also sent by a stop, ahead of the driver's own
  /// Returns the text of a reply, which may be empty; nothing: the instrument refuses.
  std::function<std::optional<std::string>(const Request&, std::span<const std::byte>)> tell;
  /// Called after the last reply instead of Result{kDone}; null: none.
  std::function<void(std::int64_t now_us, Effects&)> then = {};

  bool acts() const { return hold_us > 0 || !end.empty(); }
};

}  // namespace firn::drivers
