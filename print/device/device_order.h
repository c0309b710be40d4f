// DeviceOrder is one command of a person to an instrument, as the message that a print would send.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "firn/header_t.hpp"
#include "lcmtypes/channels.h"

namespace firn {

/// Set by whoever sends.
struct OrderStamp {
  header_t header{};
  std::int64_t command_id = 0;
  std::int64_t enable_epoch = 0;
};

struct DeviceOrder {
  std::string channel;
  std::vector<std::byte> bytes;
};

template <class Command>
DeviceOrder order_of(const Channel<Command>& channel, Command c, const OrderStamp& stamp) {
  c.header = stamp.header;
  c.command_id = stamp.command_id;
  c.enable_epoch = stamp.enable_epoch;
  DeviceOrder order{std::string(channel.name), std::vector<std::byte>(std::size_t(c.getEncodedSize()))};
  c.encode(order.bytes.data(), 0, int(order.bytes.size()));
  return order;
}

}  // namespace firn
