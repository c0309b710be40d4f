// Any text as .lcm files: as the house's, as an old log may carry them, and as two files of others. A message
// of each type, of the bytes of the text itself, is walked and printed.
#include <algorithm>
#include <stdexcept>

#include "lcmtypes/schema.h"
#include "tests/fuzz/require.h"

using namespace firn;

namespace {

void read_messages(const Schema& schema, std::span<const std::byte> bytes) {
  std::vector<std::byte> message(8);
  message.insert(message.end(), bytes.begin(), bytes.end());
  for (const schema::Type* type : schema.readable()) {
    for (const auto& field : type->fields) fuzz::require(!field.path.empty(), "a field has a path");
    for (int i = 0; i < 8; ++i)
      message[std::size_t(i)] = std::byte(std::uint64_t(type->fingerprint) >> (56 - 8 * i));
    fuzz::require(check(*type, message).has_value() == check_members(*type, message).has_value(),
                  "a right fingerprint changes nothing");
    fuzz::require(to_json(*type, message).size() >= 2, "JSON is an object");
    const auto same = schema.all_of(type->fingerprint);
    fuzz::require(std::find(same.begin(), same.end(), type) != same.end(), "a type has its fingerprint");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    read_messages(Schema::parse(text), fuzz::as_bytes(data, size));
  } catch (const std::invalid_argument&) {
  }
  const TypeFile files[] = {{"a.lcm", std::string(text.substr(0, size / 2))},
                            {"b.lcm", std::string(text.substr(size / 2))}};
  std::vector<std::string> problems;
  read_messages(Schema::parse_files(files, problems), fuzz::as_bytes(data, size));
  return 0;
}
