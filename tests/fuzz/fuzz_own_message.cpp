// Any bytes and any JSON from a program of the lab's own: a message within its limits, under the program's
// name, or one refusal. A message that was taken reads back from its own JSON.
#include <stdexcept>
#include <string>

#include "lcmtypes/schema.h"
#include "lcmtypes/validate.h"
#include "print/own/own_message.h"
#include "tests/fuzz/require.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

template <class Message>
std::vector<std::byte> encoded(Message m) {
  m.header.seq = 1;  // as the launcher's is at least
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

void check(const OwnMessage& taken, std::string_view channel) {
  const std::vector<std::byte> bytes = std::visit([](const auto& m) { return encoded(m); }, taken);
  require(!validate(*find_channel(channel), bytes), "a message that was taken is within its limits");
  const std::string program = std::visit([](const auto& m) { return m.program; }, taken);
  require(program == "room", "it bears the program's name");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view channel = own_channels()[data[0] % own_channels().size()];
  const auto rest = as_bytes(data + 1, size - 1);
  try {
    check(own_message("room", channel, rest), channel);
  } catch (const std::invalid_argument&) {
  }
  try {
    check(own_message_from_json("room", channel, {reinterpret_cast<const char*>(rest.data()), rest.size()}),
          channel);
  } catch (const std::invalid_argument&) {
  }
  return 0;
}
