#include "files/run_documents.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "files/json.h"

namespace firn {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxShown = 100;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
  throw std::invalid_argument(where + ": " + what);
}

Json object_of(std::string_view text, const std::string& name) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& e) {
    const auto* mistake = dynamic_cast<const Json::parse_error*>(&e);
    fail(name, "byte " + std::to_string(mistake ? mistake->byte : 0) + ": is no JSON");
  }
  if (!json.is_object()) fail(name, "must be a JSON object");
  return json;
}

const Json& at(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) fail(where, std::string("has no key ") + key);
  return *found;
}

std::string text_of(const Json& value, const std::string& where) {
  if (!value.is_string()) fail(where, "must be a text");
  return value.get<std::string>();
}

std::int64_t whole(const Json& value, const std::string& where, std::int64_t low, std::int64_t high) {
  const bool fits = value.is_number_unsigned() ? value.get<std::uint64_t>() <=
                                                     std::uint64_t(std::numeric_limits<std::int64_t>::max())
                                               : value.is_number_integer();
  if (!fits || value.get<std::int64_t>() < low || value.get<std::int64_t>() > high)
    fail(where, "must be a whole number in [" + std::to_string(low) + ", " + std::to_string(high) + "]");
  return value.get<std::int64_t>();
}

std::pair<std::string, std::string> input_of(const Json& input, const std::string& where) {
  if (!input.is_object()) fail(where, "must be an object");
  const std::string role = text_of(at(input, "role", where), where + ".role"),
                    sha = text_of(at(input, "sha256", where), where + ".sha256");
  if (sha.size() != 64 || sha.find_first_not_of("0123456789abcdef") != sha.npos)
    fail(where, "input '" + role.substr(0, kMaxShown) + "': '" + sha.substr(0, kMaxShown) +
                    "' is no SHA-256, 64 hexadecimal digits");
  return {role, sha};
}

// A text or a number; of objects the members, as "{"plant":1}". Nested no deeper: writing out recurses.
std::string shown(const Json& value, const std::string& where) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_structured())
    for (const Json& member : value)
      if (member.is_structured()) fail(where, "is nested too deep");
  return value.is_null() ? "" : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string ProvenanceDocument::text(std::string_view key) const {
  const auto found = std::ranges::find(texts, key, &std::pair<std::string, std::string>::first);
  return found == texts.end() ? "" : found->second;
}

ProvenanceDocument parse_provenance(std::string_view text, const std::string& name) {
  const Json json = object_of(text, name);
  ProvenanceDocument p;
  for (const auto& [key, value] : json.items()) {
    const std::string where = name + ": " + key.substr(0, kMaxShown);
    if (key == "inputs") {
      if (!value.is_array()) fail(where, "must be a list");
      p.has_inputs = true;
      for (std::size_t n = 0; n < value.size(); ++n)
        p.inputs.push_back(input_of(value[n], where + "[" + std::to_string(n) + "]"));
    } else if (key == "command_line") {
      if (!value.is_array()) fail(where, "must be a list");
      for (const Json& word : value) p.command_line.push_back(text_of(word, where));
    } else {
      if (key == "run_id") p.run_id = whole(value, where, 0, std::numeric_limits<std::int64_t>::max());
      if (key == "scheme") text_of(value, where);
      p.texts.emplace_back(key, shown(value, where));
    }
  }
  return p;
}

ResultDocument parse_result(std::string_view text, const std::string& name) {
  const Json json = object_of(text, name);
  const auto where = [&](const char* key) { return name + ": " + key; };
  const auto number = [&](const char* key) {
    return int(whole(at(json, key, name), where(key), std::numeric_limits<int>::min(),
                     std::numeric_limits<int>::max()));
  };
  return {text_of(at(json, "outcome", name), where("outcome")),
          text_of(at(json, "reason", name), where("reason")), number("status"), number("layers")};
}

}  // namespace firn
