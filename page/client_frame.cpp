#include "page/client_frame.h"

#include <stdexcept>

#include "files/json.h"

namespace firn::page {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMaxId = std::int64_t(1) << 53;
constexpr int kDeepest = 4;

// A parser that goes down a level for every bracket must not be sent down by a browser.
Json parse_object(std::string_view text, std::size_t max_bytes) {
  if (text.size() > max_bytes)
    throw std::invalid_argument("a frame of " + std::to_string(text.size()) + " bytes; at most " +
                                std::to_string(max_bytes));
  bool too_deep = false;
  const Json j = Json::parse(
      text.begin(), text.end(),
      [&](int depth, Json::parse_event_t, Json&) {
        too_deep = too_deep || depth > kDeepest;
        return !too_deep;
      },
      false);
  if (too_deep)
    throw std::invalid_argument("a frame is nested more than " + std::to_string(kDeepest) + " deep");
  if (!j.is_object()) throw std::invalid_argument("a frame must be one JSON object");
  return j;
}

std::string text_of(const Json& j, const char* key, std::size_t max_bytes) {
  const auto at = j.find(key);
  if (at == j.end() || !at->is_string()) throw std::invalid_argument(std::string(key) + ": must be a text");
  const std::string& text = at->get_ref<const std::string&>();
  if (text.size() > max_bytes)
    throw std::invalid_argument(std::string(key) + ": at most " + std::to_string(max_bytes) + " bytes");
  return text;
}

std::int64_t integer_of(const Json& j, const char* key, std::int64_t low, std::int64_t high) {
  const auto at = j.find(key);
  const bool number = at != j.end() && at->is_number_integer() &&
                      !(at->is_number_unsigned() && at->get<std::uint64_t>() > std::uint64_t(high));
  if (!number || at->get<std::int64_t>() < low || at->get<std::int64_t>() > high)
    throw std::invalid_argument(std::string(key) + ": must be an integer of " + std::to_string(low) + " to " +
                                std::to_string(high));
  return at->get<std::int64_t>();
}

// A line break would be a second order to the launcher.
std::string line_of(const Json& j, const char* key) {
  const std::string text = text_of(j, key, 1000);
  for (const char c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      throw std::invalid_argument(std::string(key) + ": must be one line of printable text");
  return text;
}

std::vector<std::string> words_of(const Json& j) {
  const std::string command = text_of(j, "command", 40);
  if (command == "set") {
    const std::string key = line_of(j, "key");
    if (key.empty() || key.find_first_of("= ") != std::string::npos)
      throw std::invalid_argument("key: must be a configuration key");
    return {"set", key + "=" + line_of(j, "value")};
  }
  static constexpr std::pair<std::string_view, std::string_view> kWords[] = {
      {"pause", "pause"},
      {"continue", "continue"},
      {"stop_after_layer", "finish-layer"},
      {"safe_stop", "stop"},
      {"accept_doubt", "accept-doubt"}};
  for (const auto& [name, word] : kWords)
    if (command == name) return {std::string(word)};
  throw std::invalid_argument(
      "command: must be pause, continue, stop_after_layer, safe_stop, accept_doubt or set");
}

}  // namespace

ClientFrame parse_client_frame(std::string_view text) {
  const Json j = parse_object(text, kMaxFrameBytes);
  const std::string type = text_of(j, "type", 20);
  ClientFrame f;
  if (type == "ping") {
    f.id = integer_of(j, "id", 0, kMaxId);
  } else if (type == "follow") {
    f.kind = ClientFrame::Kind::kFollow;
    if (const auto s = j.find("surface"); s != j.end() && !s->is_null()) {
      f.surface = surface_of(text_of(j, "surface", 20));
      if (!f.surface)
        throw std::invalid_argument(
            "surface: must be measured, target, error, planned, predicted, truth or null");
    }
    if (const auto l = j.find("layer"); l != j.end() && !l->is_null())
      f.layer = int(integer_of(j, "layer", 0, 1'000'000));
  } else if (type == "command") {
    f.kind = ClientFrame::Kind::kCommand;
    f.id = integer_of(j, "id", 0, kMaxId);
    f.words = words_of(j);
    f.token = j.contains("token") ? text_of(j, "token", 200) : "";
  } else {
    throw std::invalid_argument("type: must be follow, command or ping");
  }
  return f;
}

std::string parse_token(std::string_view text) {
  const Json j = parse_object(text, kMaxFrameBytes);
  return j.contains("token") ? text_of(j, "token", 200) : "";
}

NoteRequest parse_note_request(std::string_view text) {
  const Json j = parse_object(text, kMaxNotesBytes + kMaxFrameBytes);
  NoteRequest r;
  const auto optional_text = [&](const char* key, std::size_t most) {
    return j.contains(key) ? text_of(j, key, most) : std::string();
  };
  r.token = optional_text("token", 200);
  r.author = optional_text("author", 100);
  r.note = optional_text("note", kMaxNotesBytes);
  const auto tags_of = [&](const std::string& key) {
    std::vector<std::string> tags;
    const auto found = j.find(key);
    if (found == j.end()) return tags;
    if (!found->is_array() || found->size() > kMaxTagsOfRequest)
      throw std::invalid_argument(key + ": must be a list of at most " + std::to_string(kMaxTagsOfRequest) +
                                  " texts");
    for (const Json& tag : *found) {
      if (!tag.is_string() || tag.get_ref<const std::string&>().size() > kMaxTagBytesOfRequest)
        throw std::invalid_argument(key + ": each must be a text of at most " +
                                    std::to_string(kMaxTagBytesOfRequest) + " bytes");
      tags.push_back(tag.get<std::string>());
    }
    return tags;
  };
  r.add_tags = tags_of("add_tags");
  r.remove_tags = tags_of("remove_tags");
  return r;
}

AckRequest parse_ack_request(std::string_view text) {
  const Json j = parse_object(text, kMaxFrameBytes);
  AckRequest r;
  r.token = j.contains("token") ? text_of(j, "token", 200) : "";
  r.author = j.contains("author") ? text_of(j, "author", 100) : "";
  r.alarm = text_of(j, "alarm", kMaxFrameBytes);
  return r;
}

bool same_secret(std::string_view a, std::string_view b) {
  unsigned differs = a.size() == b.size() ? 0 : 1;
  for (std::size_t n = 0; n < a.size() && n < b.size(); ++n)
    differs |= static_cast<unsigned char>(a[n]) ^ static_cast<unsigned char>(b[n]);
  return differs == 0;
}

}  // namespace firn::page
