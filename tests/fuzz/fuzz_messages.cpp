// Reads any bytes as a message of each type: every message that check() passes is decoded whole by LCM's
// decoder and encodes back to the same bytes; walking, printing, comparing and judging never crash. Input: u8
// type, message without fingerprint.
#include <cmath>
#include <cstring>

#include "lcmtypes/channels.h"
#include "lcmtypes/schema.h"
#include "lcmtypes/validate.h"
#include "tests/fuzz/require.h"
#include "tests/lcmtypes/samples.h"

using namespace firn;
using namespace firn::fuzz;

namespace {

template <class M>
bool decode_as(const schema::Type& type, const std::vector<std::byte>& bytes) {
  if (type.fingerprint != M::getHash()) return false;
  M m;
  require(m.decode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()), "the decoder takes all bytes");
  require(test::encode(m) == bytes, "encoding gives the bytes back");
  return true;
}

template <class... M>
bool decode_as_one_of(TypeList<M...>, const schema::Type& type, const std::vector<std::byte>& bytes) {
  return (decode_as<M>(type, bytes) || ...);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const auto& types = Schema::builtin().types();
  const schema::Type& type = types[data[0] % types.size()];
  std::vector<std::byte> message(8 + size - 1);
  for (int i = 0; i < 8; ++i)
    message[std::size_t(i)] = std::byte(std::uint64_t(type.fingerprint) >> (56 - 8 * i));
  if (size > 1) std::memcpy(message.data() + 8, data + 1, size - 1);

  const bool sound = !check(type, message);
  if (sound) require(decode_as_one_of(AllTypes{}, type, message), "each type of the schema has a decoder");
  std::size_t leaves = 0, reached = 8;
  const auto stopped = for_each_leaf(type, message, [&](const Leaf& leaf) {
    require(leaf.offset >= reached && leaf.offset + leaf.bytes <= message.size(),
            "leaves follow each other in the message");
    reached = leaf.offset + leaf.bytes;
    require(!to_text(leaf).empty(), "a leaf has a text");
    return ++leaves < 5000;
  });
  require(sound == !stopped || leaves == 5000, "check() and the walk agree");
  require(to_json(type, message).size() >= 2, "JSON is an object");
  const bool valid = !validate("FUZZ", type.name, message);
  require(sound || !valid, "what is damaged is not valid");
  auto other = message;
  if (other.size() > 8) other[8 + data[0] % (other.size() - 8)] ^= std::byte{1};
  require(first_difference(type, message, other).has_value() == (other != message),
          "a changed byte is a difference");
  return 0;
}
