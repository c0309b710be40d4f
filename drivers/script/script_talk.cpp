#include "drivers/script/script_talk.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "core/options/number.h"

namespace firn::drivers::script {
namespace {

constexpr std::size_t kLongestLine = std::size_t(64) << 20;  // a picture of 8 million pixels
constexpr std::string_view kHexDigits = "0123456789abcdef";
// The driver watches each call's time by itself (script_driver.h).
constexpr std::int64_t kNever_us = std::int64_t(3600) * 1'000'000;

bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
         c == '-' || c == '/';
}

std::string_view take_word(std::string_view& line) {
  const std::size_t end = std::min(line.find(' '), line.size());
  const std::string_view word = line.substr(0, end);
  line.remove_prefix(std::min(end + 1, line.size()));
  return word;
}

// "nan" is a measurement that there is not; infinities are none.
std::optional<double> value_of(std::string_view text) {
  if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
  return whole_number<double>(text);
}

std::optional<std::vector<double>> list_of(std::string_view text) {
  std::vector<double> list;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::optional<double> value = value_of(text.substr(0, comma));
    if (!value || comma + 1 == text.size()) return std::nullopt;
    list.push_back(*value);
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return list;
}

bool take_values(std::string_view line, Values& values) {
  while (!line.empty()) {
    const std::string_view word = take_word(line);
    const std::size_t equals = word.find('=');
    if (equals == 0 || equals == word.npos) return false;
    std::optional<std::vector<double>> list = list_of(word.substr(equals + 1));
    if (!list || !values.emplace(word.substr(0, equals), std::move(*list)).second) return false;
  }
  return true;
}

std::optional<std::vector<std::byte>> bytes_of(std::string_view hex) {
  if (hex.empty() || hex.size() % 2 != 0) return std::nullopt;
  std::vector<std::byte> bytes;
  for (std::size_t n = 0; n < hex.size(); n += 2) {
    const std::optional<std::uint8_t> byte = hex_byte(hex.substr(n, 2));
    if (!byte) return std::nullopt;
    bytes.push_back(std::byte(*byte));
  }
  return bytes;
}

std::optional<Line::Why> why_of(std::string_view word) {
  if (word == "refused") return Line::Why::kRefused;
  if (word == "stopped") return Line::Why::kStopped;
  if (word == "late") return Line::Why::kLate;
  if (word == "error") return Line::Why::kError;
  return std::nullopt;
}

std::string number_text(double value) {
  if (std::isnan(value)) return "nan";
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

void append_hex(std::string& line, std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) {
    line += kHexDigits[std::size_t(b) >> 4];
    line += kHexDigits[std::size_t(b) & 15];
  }
}

}  // namespace

double Line::number(std::string_view name) const {
  const auto at = values.find(name);
  return at == values.end() || at->second.size() != 1 ? std::numeric_limits<double>::quiet_NaN()
                                                      : at->second.front();
}

std::string encode_text(std::string_view text) {
  std::string coded;
  for (const char c : text) {
    if (is_plain(c)) {
      coded += c;
    } else {
      coded += '%';
      append_hex(coded, std::as_bytes(std::span(&c, 1)));
    }
  }
  return coded;
}

std::optional<std::string> decode_text(std::string_view coded) {
  std::string text;
  for (std::size_t n = 0; n < coded.size(); ++n) {
    if (coded[n] != '%') {
      text += coded[n];
      continue;
    }
    const std::optional<std::uint8_t> byte = hex_byte(coded.substr(n + 1, 2));
    if (!byte) return std::nullopt;
    text += char(*byte);
    n += 2;
  }
  return text;
}

std::optional<Line> parse_line(std::string_view line) {
  Line l;
  const std::string_view word = take_word(line);
  const auto take_text = [&] {
    const std::string_view coded = take_word(line);
    if (!coded.starts_with(':')) return false;
    std::optional<std::string> text = decode_text(coded.substr(1));
    if (text) l.text = std::move(*text);
    return text.has_value();
  };
  if (word == "note") {
    l.kind = Line::Kind::kNote;
    return take_text() && line.empty() ? std::optional(std::move(l)) : std::nullopt;
  }
  const std::optional<std::int32_t> call = whole_number<std::int32_t>(take_word(line), 1, INT32_MAX);
  if (!call) return std::nullopt;
  l.call = *call;
  if (word == "done") {
    l.kind = Line::Kind::kDone;
    return take_text() && take_values(line, l.values) ? std::optional(std::move(l)) : std::nullopt;
  }
  if (word == "fail") {
    l.kind = Line::Kind::kFailed;
    const std::optional<Line::Why> why = why_of(take_word(line));
    if (!why || !take_text() || !line.empty()) return std::nullopt;
    l.why = *why;
    return l;
  }
  if (word == "write") {
    l.kind = Line::Kind::kWrite;
    std::optional<std::vector<std::byte>> bytes = bytes_of(line);
    if (!bytes) return std::nullopt;
    l.bytes = std::move(*bytes);
    return l;
  }
  return std::nullopt;
}

std::string call_line(std::int32_t call, double limit_s, std::string_view method, const Values& arguments) {
  std::string line = "call " + std::to_string(call) + " " + number_text(limit_s) + " " + std::string(method);
  for (const auto& [name, values] : arguments) {
    line += " " + name + "=";
    for (std::size_t n = 0; n < values.size(); ++n) line += (n == 0 ? "" : ",") + number_text(values[n]);
  }
  return line + "\n";
}

std::string begin_line(std::int32_t call, std::string_view file, std::string_view class_name,
                       std::string_view arguments, bool has_line, std::span<const std::string_view> methods) {
  std::string line = "begin " + std::to_string(call) + " " + std::string(file) + " " +
                     std::string(class_name) + " :" + encode_text(arguments) + (has_line ? " 1" : " 0");
  for (const std::string_view method : methods) line += " " + std::string(method);
  return line + "\n";
}

std::string stop_line(std::int32_t call, double limit_s) {
  return "stop " + std::to_string(call) + " " + number_text(limit_s) + "\n";
}

std::string line_line(bool open) { return open ? "line 1\n" : "line 0\n"; }

std::string bytes_line(std::span<const std::byte> bytes) {
  std::string line = "bytes ";
  append_hex(line, bytes);
  return line + "\n";
}

ScriptDialect::ScriptDialect() {
  numbered = true;  // a line that answers another call is passed over
  max_attempts = 1;
  timeouts = {.lock_us = kNever_us,
              .write_us = 0,
              .reply_us = kNever_us,
              .read_us = kNever_us,
              .quiet_us = 0,
              .opening_us = 0};
}

Frame ScriptDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all = text_of(buffer);
  const std::size_t end = all.find('\n');
  if (end == all.npos) return all.size() > kLongestLine ? Frame{Frame::Kind::kCorrupt, all.size()} : Frame{};
  const std::size_t size = end + 1;
  const std::string_view line = all.substr(0, end);
  if (line.starts_with("write ") || line.starts_with("note ")) return {Frame::Kind::kUnsolicited, size};
  std::string_view rest = line;
  const std::string_view word = take_word(rest);
  const std::optional<std::int32_t> call = whole_number<std::int32_t>(take_word(rest), 1, INT32_MAX);
  if (!call || (word != "done" && word != "fail")) return {Frame::Kind::kCorrupt, size};
  return {awaited && awaited->argument == *call ? Frame::Kind::kReply : Frame::Kind::kIgnore, size};
}

Request ScriptDialect::request(std::int32_t call, std::string line, std::uint16_t tag) {
  Request r;
  r.repeat = Repeat::kNever;
  r.tag = tag;
  r.argument = call;
  lines_.clear();  // of calls that were never sent: one is asked at a time
  lines_.emplace(call, std::move(line));
  return r;
}

void ScriptDialect::write(const Request& request, std::vector<std::byte>& tx) const {
  const auto at = lines_.find(request.argument);
  if (at == lines_.end()) return;
  const auto bytes = std::as_bytes(std::span(at->second));
  tx.insert(tx.end(), bytes.begin(), bytes.end());
}

}  // namespace firn::drivers::script
