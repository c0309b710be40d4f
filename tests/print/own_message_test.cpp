// Messages of the lab's own programs: those taken from bytes and from JSON, and those refused by member.
#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/grid/random.h"
#include "lcmtypes/schema.h"
#include "print/own/message_from_json.h"
#include "print/own/own_message.h"

using namespace firn;
using Catch::Contains;

namespace {

std::string own_message_refusal(const std::string& channel, const std::string& json) {
  try {
    own_message_from_json("room", channel, json);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "taken";
}

template <class Message>
std::vector<std::byte> encoded(const Message& m) {
  std::vector<std::byte> bytes(std::size_t(m.getEncodedSize()));
  m.encode(bytes.data(), 0, int(bytes.size()));
  return bytes;
}

own_values_t some_values() {
  own_values_t m{};
  m.name = "room";
  m.unit = "degC";
  m.values = {20.5, std::nan("")};
  m.n = 2;
  return m;
}

const char* kGood = R"({"name": "room", "unit": "degC", "sample_utime_us": 0, "values": [20.5]})";

}  // namespace

TEST_CASE("a message of a program of the lab's own gets the program's name, whatever it says", "[own]") {
  own_values_t sent = some_values();
  sent.program = "safety";
  sent.header.run_id = 99;
  const auto taken = std::get<own_values_t>(own_message("room", "OWN_VALUES", encoded(sent)));
  CHECK(taken.program == "room");
  CHECK(taken.header.run_id == 0);
  CHECK(taken.name == "room");
  REQUIRE(taken.values.size() == 2);
  CHECK(taken.values[0] == 20.5);
  CHECK(std::isnan(taken.values[1]));
}

TEST_CASE("a program of the lab's own publishes values and estimates, and no other channel", "[own]") {
  CHECK(own_channels().size() == std::variant_size_v<OwnMessage>);
  for (const ChannelInfo& row : channel_table()) {
    INFO(row.name);
    const bool open = row.name.starts_with("OWN_");
    CHECK((own_message_refusal(std::string(row.name), "{}").find("is not for programs") ==
           std::string::npos) == open);
  }
  CHECK_THAT(own_message_refusal("JET_COMMAND", "{}"),
             Contains("JET_COMMAND: is not for programs of the lab's own; they may publish OWN_VALUES"));
  CHECK_THAT(own_message_refusal("OWN_VALUE", "{}"), Contains("there is no such channel"));
}

TEST_CASE("bytes of another type, cut off, or out of a range are refused by byte and member", "[own]") {
  const auto why = [](std::string_view channel, const std::vector<std::byte>& bytes) -> std::string {
    try {
      own_message("room", channel, bytes);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "taken";
  };
  const std::vector<std::byte> good = encoded(some_values());
  CHECK(why("OWN_VALUES", good) == "taken");
  CHECK_THAT(why("OWN_HEIGHT_MODEL", good), Contains("OWN_HEIGHT_MODEL: byte 0"));
  for (std::size_t size = 0; size < good.size(); ++size)
    CHECK_THAT(why("OWN_VALUES", {good.begin(), good.begin() + long(size)}),
               Catch::StartsWith("OWN_VALUES: byte"));
  own_height_model_t model{};
  model.h1_mm = -0.01;
  CHECK_THAT(why("OWN_HEIGHT_MODEL", encoded(model)), Contains("h1_mm = -0.01 is outside"));
}

TEST_CASE("damaged bytes are a message within its limits under the program's name, or are refused", "[own]") {
  const std::vector<std::byte> good = encoded(some_values());
  int refused = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    std::vector<std::byte> bytes = good;
    for (std::uint32_t n = 1 + random.below(6); n > 0; --n)
      bytes[random.below(std::uint32_t(bytes.size()))] = std::byte(random.below(256));
    bytes.resize(random.below(std::uint32_t(bytes.size() + 1)));
    try {
      auto taken = std::get<own_values_t>(own_message("room", "OWN_VALUES", bytes));
      CHECK(taken.program == "room");
      CHECK(std::size_t(taken.n) == taken.values.size());
      CHECK(taken.n <= 4096);
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  CHECK(refused > 1000);  // most are cut off
}

TEST_CASE("a JSON object becomes the message that LCM's own encoder makes of its members", "[own]") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    RandomStream random(seed, Purpose::kTest);
    own_values_t m{};
    m.name = "n\"\\\t\xc3\xa9" + std::to_string(random.below(100));
    m.unit = random.below(2) ? "" : "mm";
    m.sample_utime_us = std::int64_t(random.below(1u << 31)) << random.below(22);
    m.n = std::int32_t(random.below(6));
    for (int k = 0; k < m.n; ++k)
      m.values.push_back(std::ldexp(double(random.below(1u << 30)) - 5e8, int(random.below(200)) - 100));
    const std::vector<std::byte> bytes = encoded(m);
    const schema::Type& type = *Schema::builtin().find("own_values_t");
    JsonOptions whole;
    whole.full = true;
    INFO("seed " << seed);
    CHECK(message_from_json(type, to_json(type, bytes, whole)) == bytes);
  }
}

TEST_CASE("members of JSON that are missing, unknown or of another kind are named", "[own]") {
  CHECK(own_message_refusal("OWN_VALUES", kGood) == "taken");
  CHECK_THAT(own_message_refusal("OWN_VALUES", "{\"name\": 1"), Contains("no JSON: byte 11"));
  CHECK_THAT(own_message_refusal("OWN_VALUES", "[1]"), Contains("no JSON object"));
  CHECK_THAT(own_message_refusal("OWN_VALUES", R"({"name": "a", "unit": "", "sample_utime_us": 0})"),
             Contains("OWN_VALUES: values: is missing"));
  CHECK_THAT(own_message_refusal("OWN_VALUES", R"({"value": [1]})"),
             Contains("value: own_values_t has no such member; it has header, program, name"));
  CHECK_THAT(
      own_message_refusal("OWN_VALUES", R"({"name": 3, "unit": "", "sample_utime_us": 0, "values": []})"),
      Contains("name: 3 is no text"));
  CHECK_THAT(
      own_message_refusal("OWN_VALUES", R"({"name": "", "unit": "", "sample_utime_us": 0.5, "values": []})"),
      Contains("sample_utime_us: 0.5 is no whole number"));
  CHECK_THAT(own_message_refusal("OWN_VALUES",
                                 R"({"name": "", "unit": "", "sample_utime_us": 0, "n": 2, "values": [1]})"),
             Contains("n: 2 is not the 1 elements of values"));
  CHECK_THAT(own_message_refusal("OWN_FLOW_MODEL", R"({"layer": 3000000000, "factor": [1, 1]})"),
             Contains("layer: 3000000000 is outside -2147483648 to 2147483647"));
  CHECK_THAT(own_message_refusal("OWN_FLOW_MODEL", R"({"layer": 1, "factor": [1]})"),
             Contains("factor: has 1 elements, not 2"));
  CHECK_THAT(own_message_refusal("OWN_FLOW_MODEL", R"({"layer": 1, "factor": [0, 1]})"),
             Contains("factor[0] = 0 is outside"));
}
