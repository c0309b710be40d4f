#include "drivers/laser_point/lkg.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/options/number.h"

namespace firn::drivers::lkg {
namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

/// The part of a command that its reply repeats: `SW,CA` of `SW,CA,5`, `SR,HB` of `SR,HB,1`, else the first
/// two letters.
std::string_view echo_of(std::string_view command) {
  const bool setting = command.starts_with("SW,") || command.starts_with("SR,");
  return command.substr(0, setting ? 5 : 2);
}

}  // namespace

Value parse_value(std::string_view text, std::size_t chars) {
  const Value damaged{Status::kDamaged, std::numeric_limits<double>::quiet_NaN()};
  if (text.size() != chars && text.size() != kValueChars) return damaged;
  if (text == "XXXXXXXX") return {};
  const char sign = text[0];
  if (sign != '+' && sign != '-') return damaged;
  text.remove_prefix(1);
  if (text == "FFFFFFF") return {sign == '+' ? Status::kAbove : Status::kBelow, damaged.mm};
  if (text.size() + 1 != chars) return damaged;
  // Digits with one point between them; anything else, also an exponent or a second sign, is no value.
  int points = 0;
  for (const char c : text) {
    if (c != '.' && !digit(c)) return damaged;
    points += c == '.';
  }
  if (points != 1 || !digit(text.front()) || !digit(text.back())) return damaged;
  const std::optional<double> mm = whole_number<double>(text);
  return mm ? Value{Status::kOk, sign == '-' ? -*mm : *mm} : damaged;
}

int cycle_code(int samples) {
  const auto at = std::find(std::begin(kCycles), std::end(kCycles), samples);
  return at == std::end(kCycles) ? -1 : int(at - std::begin(kCycles));
}

Request request(std::string_view command, Repeat repeat, std::uint16_t tag, std::int64_t reply_us) {
  Request r;
  r.append(command);
  r.append("\r");
  r.repeat = repeat;
  r.tag = tag;
  r.reply_us = reply_us;
  return r;
}

Reply parse(std::string_view line, std::string_view command) {
  if (line.starts_with("TG,")) return {Reply::Kind::kTiming, 0, line.substr(3)};
  const std::string_view echo = echo_of(command);
  if (line.starts_with("ER,")) {
    line.remove_prefix(3);
    const std::size_t comma = line.rfind(',');
    if (comma == std::string_view::npos || line.size() != comma + 3 || !digit(line[comma + 1]) ||
        !digit(line[comma + 2]))
      return {};
    const std::string_view named = line.substr(0, 2);  // a setting's identifier, or SW
    if (named != echo.substr(0, 2) && (echo.size() < 5 || named != echo.substr(3))) return {};
    return {Reply::Kind::kError, (line[comma + 1] - '0') * 10 + (line[comma + 2] - '0'), {}};
  }
  if (!line.starts_with(echo)) return {};
  line.remove_prefix(echo.size());
  if (line.empty()) return {Reply::Kind::kDone, 0, {}};
  if (line[0] != ',') return {};
  return {Reply::Kind::kDone, 0, line.substr(1)};
}

std::optional<Stored> parse_stored(std::string_view rest) {
  if (rest.size() < 3 || (rest[0] != '0' && rest[0] != '1') || rest[1] != ',') return std::nullopt;
  Stored s;
  s.storing = rest[0] == '1';
  rest.remove_prefix(2);
  for (int output = 0; output < 2; ++output) {
    const std::optional<int> values = take_number<int>(rest);
    if (!values || *values < 0) return std::nullopt;
    if (output == 0) s.values = *values;
    if (rest.empty()) return s;
    if (rest[0] != ',') return std::nullopt;
    rest.remove_prefix(1);
  }
  return std::nullopt;
}

std::optional<int> parse_dump(std::string_view rest, std::vector<float>& mm, std::size_t chars) {
  mm.clear();
  if (rest == "1") return 0;
  if (rest.starts_with("1,")) rest.remove_prefix(2);
  mm.reserve((rest.size() + 1) / (chars + 1));
  int damaged = 0;
  while (true) {
    const std::string_view one = rest.substr(0, rest.find(','));
    if (one.size() != chars && one.size() != kValueChars) return std::nullopt;
    const Value v = parse_value(one, chars);
    damaged += v.status == Status::kDamaged;
    mm.push_back(float(v.mm));
    if (one.size() == rest.size()) return damaged;
    rest.remove_prefix(one.size() + 1);
  }
}

LkgDialect::LkgDialect() {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 100'000;
  timeouts.quiet_us = 150'000;
  timeouts.lock_us = 5'000'000;
}

Frame LkgDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all = text_of(buffer);
  const std::size_t end = all.find('\r');
  const bool dump = awaited && awaited->text().starts_with(table.dump.substr(0, 2));
  const std::size_t longest =
      dump ? std::size_t(table.most_stored) * std::size_t(table.value_bytes) + 16 : 64;
  if (std::min(end, all.size()) > longest) return {Frame::Kind::kCorrupt, std::min(end, all.size())};
  if (end == std::string_view::npos) return {};
  const std::size_t size = end + 1;
  if (!awaited) {
    const bool timing = all.starts_with("TG,");
    return {timing ? Frame::Kind::kUnsolicited : Frame::Kind::kCorrupt, size};
  }
  const std::string_view line = all.substr(0, end), command = awaited->text().substr(0, awaited->size - 1u);
  // A line that comes back as it was sent is an echo: an answer has a value behind the name, or the name
  // alone.
  if (line == command && (awaited->repeat == Repeat::kRead || command != echo_of(command)))
    return {Frame::Kind::kCorrupt, size};
  const Reply r = parse(line, command);
  switch (r.kind) {
    case Reply::Kind::kTiming:
      return {Frame::Kind::kUnsolicited, size};
    case Reply::Kind::kForeign:
      return {Frame::Kind::kCorrupt, size};
    default:
      return {Frame::Kind::kReply, size};
  }
}

Request LkgDialect::probe() const { return request(table.selected, Repeat::kRead, 0); }

LinkProbe link_probe() {
  return {
      "a Keyence LK-G laser", "PR\r",
      [](std::string_view s) { return s.ends_with('\r') && (s.starts_with("PR,") || s.starts_with("ER,")); },
      '\r'};
}

}  // namespace firn::drivers::lkg
