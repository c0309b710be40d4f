// Maps and events as Foxglove's messages: cells against an own reader of the packed bytes, lines of the log
// by kind of message.
#include "report/export/foxglove.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/grid/device.h"
#include "core/grid/random.h"
#include "files/base64.h"
#include "files/json.h"
#include "firn/enums.h"
#include "firn/fault_t.hpp"
#include "firn/height_map_t.hpp"
#include "firn/layer_metrics_t.hpp"
#include "firn/operator_command_t.hpp"
#include "firn/run_end_t.hpp"
#include "firn/run_start_t.hpp"
#include "firn/safe_stop_t.hpp"

namespace firn::report {
namespace {

using nlohmann::json;

template <class Message>
struct Encoded {
  std::vector<std::byte> bytes;
  const schema::Type* type = nullptr;
  std::vector<FieldPlace> places;

  explicit Encoded(const Message& m) : bytes(std::size_t(m.getEncodedSize())) {
    REQUIRE(m.encode(bytes.data(), 0, int(bytes.size())) == int(bytes.size()));
    type = Schema::builtin().type_of(bytes);
    REQUIRE(type);
    places.resize(type->fields.size());
    REQUIRE(!check(*type, bytes, places));
  }
  std::optional<std::string> grid(std::uint64_t time_ns = 0) const {
    return foxglove_grid(*type, bytes, places, time_ns);
  }
  FoxgloveLog log() const {
    const auto log = foxglove_log(*type, bytes);
    REQUIRE(log);
    return *log;
  }
};

height_map_t map_of(int nx, int ny, RandomStream& random) {
  height_map_t m{};
  m.grid = {};
  m.grid.nx = nx;
  m.grid.ny = ny;
  m.grid.pitch_x_mm = 0.25;
  m.grid.pitch_y_mm = 0.5;
  m.grid.origin_x_mm = 3.0;
  m.grid.origin_y_mm = -2.0;
  m.n = nx * ny;
  for (int c = 0; c < m.n; ++c) {
    m.height_mm.push_back(c % 5 == 4 ? NAN : float(random.uniform()));
    m.quality.push_back(std::int8_t(c % 3));
  }
  return m;
}

/// RFC 4648, section 4.
std::string unpacked(const std::string& text) {
  std::string out;
  unsigned bits = 0, have = 0;
  for (const char c : text) {
    if (c == '=') break;
    const unsigned value = c >= 'a'   ? unsigned(c - 'a') + 26
                           : c >= 'A' ? unsigned(c - 'A')
                           : c >= '0' ? unsigned(c - '0') + 52
                           : c == '+' ? 62u
                                      : 63u;
    bits = bits << 6 | value;
    if ((have += 6) < 8) continue;
    have -= 8;
    out += char(bits >> have & 255);
  }
  return out;
}

}  // namespace

TEST_CASE("bytes of every length come back from their text of base 64") {
  RandomStream random(41, Purpose::kTest);
  for (std::size_t size = 0; size < 70; ++size) {
    std::vector<std::byte> bytes(size);
    for (std::byte& b : bytes) b = std::byte(random.below(256));
    const std::string text = base64(bytes);
    CHECK(text.size() == (size + 2) / 3 * 4);
    const std::string back = unpacked(text);
    REQUIRE(back.size() == size);
    CHECK(std::memcmp(back.data(), bytes.data(), size) == 0);
  }
}

TEST_CASE("each map of a message is a field of Foxglove's cells, little endian, row by row") {
  RandomStream random(42, Purpose::kTest);
  for (const auto& [nx, ny] : {std::pair(1, 1), std::pair(7, 3), std::pair(2, 9)}) {
    const height_map_t m = map_of(nx, ny, random);
    const auto text = Encoded(m).grid(12'000'000'345);
    REQUIRE(text);
    const json j = json::parse(*text);
    CHECK(j["timestamp"] == json{{"sec", 12}, {"nsec", 345}});
    CHECK(j["frame_id"] == "part");
    CHECK(j["column_count"] == nx);
    CHECK(j["cell_stride"] == 5);
    CHECK(j["row_stride"] == 5 * nx);
    CHECK(j["pose"]["position"]["x"] == 3.0 - 0.125);
    CHECK(j["pose"]["position"]["y"] == -2.0 - 0.25);
    CHECK(j["cell_size"] == json{{"x", 0.25}, {"y", 0.5}});
    REQUIRE(j["fields"].size() == 2);
    CHECK(j["fields"][0] == json{{"name", "height_mm"}, {"offset", 0}, {"type", 7}});
    CHECK(j["fields"][1] == json{{"name", "quality"}, {"offset", 4}, {"type", 2}});
    const std::string cells = unpacked(j["data"].get<std::string>());
    REQUIRE(cells.size() == std::size_t(5 * nx * ny));
    for (std::size_t c = 0; c < std::size_t(m.n); ++c) {
      float height = 0;
      std::memcpy(&height, cells.data() + 5 * c, 4);
      CHECK((height == m.height_mm[c] || (std::isnan(height) && std::isnan(m.height_mm[c]))));
      CHECK(std::int8_t(cells[5 * c + 4]) == m.quality[c]);
    }
  }
}

TEST_CASE("a message without a grid, or without a map on it, is no grid of Foxglove's") {
  CHECK_FALSE(Encoded(layer_metrics_t{}).grid());
  CHECK_FALSE(Encoded(fault_t{}).grid());
  height_map_t none{};  // no cells
  CHECK_FALSE(Encoded(none).grid());
}

TEST_CASE("faults are lines of the log by their severity and node") {
  for (const auto& [severity, level] :
       {std::pair(Severity::kNotice, 2), std::pair(Severity::kWarning, 3), std::pair(Severity::kStop, 4)}) {
    fault_t m{};
    m.severity = std::int8_t(severity);
    m.node = "jet";
    m.text = "no \"droplets\"";
    CHECK(Encoded(m).log() == FoxgloveLog{level, "jet", "no \"droplets\""});
  }
}

TEST_CASE("orders are lines of the log with the person who gave them") {
  operator_command_t m{};
  m.verb = std::int8_t(OperatorVerb::kSet);
  m.key = "control.max_layers";
  m.value = "40";
  m.text = "Ada (page)";
  CHECK(Encoded(m).log() == FoxgloveLog{2, "Ada (page)", "set control.max_layers=40"});
  m.verb = std::int8_t(OperatorVerb::kStop);
  CHECK(Encoded(m).log().text == "stop");
  m.verb = 99;  // of a later version
  CHECK(Encoded(m).log().text == "order 99");
}

TEST_CASE("a stop, a start and an end of the run are lines of the log, and a metric is none") {
  safe_stop_t stop{};
  stop.cause = "the lamp is disconnected";
  CHECK(Encoded(stop).log() == FoxgloveLog{4, "safety", "safe stop: the lamp is disconnected"});
  run_start_t start{};
  start.name = "cylinder";
  CHECK(Encoded(start).log().text == "begins: cylinder");
  run_end_t end{};
  end.layers = 53;
  end.reason = "the last layer is printed";
  CHECK(Encoded(end).log().text == "ends after layer 53: the last layer is printed");
  const Encoded metrics(layer_metrics_t{});
  CHECK_FALSE(foxglove_log(*metrics.type, metrics.bytes));
}

TEST_CASE("a line of the log and its schema have the members that Foxglove names") {
  const json line = json::parse(log_json({3, "jet", "dry"}, 1'500'000'000));
  const json schema = json::parse(foxglove_schema(kFoxgloveLog));
  CHECK(schema["title"] == "foxglove.Log");
  for (const char* member : {"timestamp", "level", "message", "name", "file", "line"}) {
    CHECK(line.contains(member));
    CHECK(schema["properties"].contains(member));
  }
  CHECK(line["timestamp"]["nsec"] == 500'000'000);
  CHECK(schema["properties"]["level"]["oneOf"][3] == json{{"title", "WARNING"}, {"const", 3}});
  const json grid = json::parse(foxglove_schema(kFoxgloveGrid));
  CHECK(grid["title"] == "foxglove.Grid");
  CHECK(grid["properties"]["fields"]["items"]["properties"]["type"]["oneOf"][7]["title"] == "FLOAT32");
  CHECK(grid["properties"]["data"]["contentEncoding"] == "base64");
}

}  // namespace firn::report
