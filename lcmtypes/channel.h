// Channel holds a channel's name together with its message type: Outbox::send and Node::subscribe accept no
// other message.
#pragma once

#include <string_view>

namespace firn {

template <class Message>
struct Channel {
  std::string_view name;
};

}  // namespace firn
