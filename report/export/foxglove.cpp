#include "report/export/foxglove.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <vector>

#include "core/grid/device.h"
#include "files/base64.h"
#include "files/json.h"
#include "files/record/event_format.h"
#include "firn/enums.h"

namespace firn::report {
namespace {

using Json = nlohmann::ordered_json;
using schema::Field;
using schema::Kind;
using schema::Type;

constexpr double kMaxSide = 4096;  // of grid_t

// foxglove.NumericType
int numeric_type(Kind kind) {
  switch (kind) {
    case Kind::kByte:
    case Kind::kBoolean:
      return 1;  // UINT8
    case Kind::kInt8:
      return 2;
    case Kind::kInt16:
      return 4;
    case Kind::kInt32:
      return 6;
    case Kind::kFloat:
      return 7;
    case Kind::kDouble:
      return 8;
    default:
      return 0;  // 64-bit integers and texts have none
  }
}

constexpr int kInfo = 2, kWarning = 3, kError = 4;  // foxglove.LogLevel

Json time_json(std::uint64_t ns) {
  constexpr std::uint64_t kSecond_ns = 1'000'000'000;
  return {{"sec", ns / kSecond_ns}, {"nsec", ns % kSecond_ns}};
}

std::string dumped(const Json& j) { return j.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json object(std::initializer_list<std::pair<const char*, Json>> members) {
  Json properties = Json::object();
  for (const auto& [name, schema] : members) properties[name] = schema;
  return {{"type", "object"}, {"properties", properties}};
}

Json titled(const char* title, Json schema) {
  schema["title"] = title;
  return schema;
}

Json number() { return {{"type", "number"}}; }
Json count() { return {{"type", "integer"}, {"minimum", 0}}; }

Json time_schema() {
  Json nsec = count();
  nsec["maximum"] = 999'999'999;
  return titled("time", object({{"sec", count()}, {"nsec", nsec}}));
}

Json names(std::initializer_list<const char*> of_values) {
  Json one_of = Json::array();
  for (const char* name : of_values) one_of.push_back({{"title", name}, {"const", one_of.size()}});
  return {{"oneOf", one_of}};
}

Json grid_schema() {
  const Json position =
      titled("foxglove.Vector3", object({{"x", number()}, {"y", number()}, {"z", number()}}));
  const Json orientation = titled(
      "foxglove.Quaternion", object({{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}}));
  const Json type =
      names({"UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64"});
  const Json field = titled("foxglove.PackedElementField",
                            object({{"name", {{"type", "string"}}}, {"offset", count()}, {"type", type}}));
  return titled("foxglove.Grid",
                object({{"timestamp", time_schema()},
                        {"frame_id", {{"type", "string"}}},
                        {"pose", titled("foxglove.Pose",
                                        object({{"position", position}, {"orientation", orientation}}))},
                        {"column_count", count()},
                        {"cell_size", titled("foxglove.Vector2", object({{"x", number()}, {"y", number()}}))},
                        {"row_stride", count()},
                        {"cell_stride", count()},
                        {"fields", {{"type", "array"}, {"items", field}}},
                        {"data", {{"type", "string"}, {"contentEncoding", "base64"}}}}));
}

Json log_schema() {
  return titled("foxglove.Log",
                object({{"timestamp", time_schema()},
                        {"level", names({"UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL"})},
                        {"message", {{"type", "string"}}},
                        {"name", {{"type", "string"}}},
                        {"file", {{"type", "string"}}},
                        {"line", count()}}));
}

// The value of a field that is one number of four or eight bytes.
double value(const Field& field, const FieldPlace& place, std::span<const std::byte> message) {
  const std::byte* p = message.data() + place.offset;
  if (field.kind == Kind::kInt32) return double(std::int32_t(record::big32(p)));
  return std::bit_cast<double>(record::big64(p));
}

std::string order_words(std::int64_t verb, const std::string& key, const std::string& value) {
  switch (OperatorVerb(verb)) {
    case OperatorVerb::kAcceptDoubt:
      return "accept doubt";
    case OperatorVerb::kPause:
      return "pause";
    case OperatorVerb::kContinue:
      return "continue";
    case OperatorVerb::kFinishLayer:
      return "finish the layer and end";
    case OperatorVerb::kStop:
      return "stop";
    case OperatorVerb::kSet:
      return "set " + key + "=" + value;
  }
  return "order " + std::to_string(verb);
}

}  // namespace

std::string foxglove_schema(std::string_view name) {
  return dumped(name == kFoxgloveGrid ? grid_schema() : log_schema());
}

std::optional<std::string> foxglove_grid(const Type& type, std::span<const std::byte> message,
                                         std::span<const FieldPlace> places, std::uint64_t time_ns) {
  std::map<std::string_view, double> grid;
  for (std::size_t i = 0; i < type.fields.size(); ++i)
    for (const char* name : {"nx", "ny", "pitch_x_mm", "pitch_y_mm", "origin_x_mm", "origin_y_mm"})
      if (type.fields[i].path == std::string("grid.") + name)
        grid[name] = value(type.fields[i], places[i], message);
  const auto side = [](double n) { return n >= 1 && n <= kMaxSide; };
  if (grid.size() != 6 || !side(grid["nx"]) || !side(grid["ny"])) return {};
  const auto columns = std::size_t(grid["nx"]), cells = columns * std::size_t(grid["ny"]);
  struct Map {
    std::size_t at = 0, bytes = 0;
  };
  std::vector<Map> maps;
  Json fields = Json::array();
  std::size_t stride = 0;
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    const Field& f = type.fields[i];
    const int kind = numeric_type(f.kind);
    if (kind == 0 || f.dimensions.size() != 1 || !f.dimensions[0].variable || places[i].count != cells)
      continue;
    fields.push_back({{"name", f.path}, {"offset", stride}, {"type", kind}});
    maps.push_back({places[i].offset, schema::size_of(f.kind)});
    stride += maps.back().bytes;
  }
  if (maps.empty()) return {};
  std::vector<std::byte> packed;
  packed.reserve(cells * stride);
  for (std::size_t cell = 0; cell < cells; ++cell)
    for (const Map& map : maps) {  // LCM is big endian, Foxglove little
      const std::byte* first = message.data() + map.at + cell * map.bytes;
      std::reverse_copy(first, first + map.bytes, std::back_inserter(packed));
    }
  // The pose is that of the grid's corner, the origin is the centre of the first cell.
  const double px = grid["pitch_x_mm"], py = grid["pitch_y_mm"];
  const Json position = {
      {"x", grid["origin_x_mm"] - px / 2}, {"y", grid["origin_y_mm"] - py / 2}, {"z", 0.0}};
  const Json orientation = {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}, {"w", 1.0}};
  return dumped({{"timestamp", time_json(time_ns)},
                 {"frame_id", "part"},
                 {"pose", {{"position", position}, {"orientation", orientation}}},
                 {"column_count", columns},
                 {"cell_size", {{"x", px}, {"y", py}}},
                 {"row_stride", columns * stride},
                 {"cell_stride", stride},
                 {"fields", fields},
                 {"data", base64(packed)}});
}

std::optional<FoxgloveLog> foxglove_log(const Type& type, std::span<const std::byte> message) {
  static constexpr std::array kTypes{"fault_t", "safe_stop_t", "operator_command_t", "run_start_t",
                                     "run_end_t"};
  if (std::ranges::find(kTypes, type.name) == kTypes.end()) return {};
  std::map<std::string, std::string, std::less<>> texts;
  std::map<std::string, std::int64_t, std::less<>> numbers;
  for_each_leaf(type, message, [&](const Leaf& leaf) {
    if (const auto* text = std::get_if<std::string_view>(&leaf.value)) texts[std::string(leaf.path)] = *text;
    if (const auto* n = std::get_if<std::int64_t>(&leaf.value)) numbers[std::string(leaf.path)] = *n;
    return true;
  });
  if (type.name == "fault_t") {
    const auto severity = Severity(numbers["severity"]);
    const int level = severity == Severity::kStop      ? kError
                      : severity == Severity::kWarning ? kWarning
                                                       : kInfo;
    return FoxgloveLog{level, texts["node"], texts["text"]};
  }
  if (type.name == "safe_stop_t") return FoxgloveLog{kError, "safety", "safe stop: " + texts["cause"]};
  if (type.name == "operator_command_t")
    return FoxgloveLog{kInfo, texts["text"], order_words(numbers["verb"], texts["key"], texts["value"])};
  if (type.name == "run_start_t") return FoxgloveLog{kInfo, "print", "begins: " + texts["name"]};
  return FoxgloveLog{kInfo, "print",
                     "ends after layer " + std::to_string(numbers["layers"]) + ": " + texts["reason"]};
}

std::string log_json(const FoxgloveLog& log, std::uint64_t time_ns) {
  return dumped({{"timestamp", time_json(time_ns)},
                 {"level", log.level},
                 {"message", log.text},
                 {"name", log.name},
                 {"file", ""},
                 {"line", 0}});
}

}  // namespace firn::report
