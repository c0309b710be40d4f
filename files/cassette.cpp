#include "files/cassette.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "core/options/number.h"

namespace firn {
namespace {

constexpr std::string_view kHead = "firn cassette 1 ";
constexpr std::string_view kConfig = "config: ";
constexpr double kLongest_ms = 1e12;

[[noreturn]] void refuse(const std::string& file, int line, const std::string& why) {
  throw std::invalid_argument(file + ":" + std::to_string(line) + ": " + why);
}

std::string_view next_word(std::string_view& rest) {
  const std::size_t begin = rest.find_first_not_of(' ');
  rest.remove_prefix(begin == std::string_view::npos ? rest.size() : begin);
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

int digit(char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; }

std::string time_of(double ms) {
  char text[40];
  std::snprintf(text, sizeof text, "%12.3f ", ms);
  return text;
}

std::string hex_of(std::span<const std::byte> bytes) {
  static constexpr char kHex[] = "0123456789abcdef";
  std::string text;
  for (const std::byte b : bytes) text += {' ', kHex[unsigned(b) >> 4], kHex[unsigned(b) & 15]};
  return text;
}

Cassette::Piece piece_of(std::string_view text, const std::string& file, int line) {
  std::string_view rest = text.substr(0, text.find('|'));
  Cassette::Piece p;
  p.line = line;
  const std::string_view time = next_word(rest), what = next_word(rest);
  const std::optional<double> ms = whole_number(time, 0.0, kLongest_ms);
  if (!ms) refuse(file, line, "'" + std::string(time) + "' is no time in [0, 1e12] ms");
  p.ms = *ms;
  const bool sent = what == ">", received = what == "<", order = what == "=";
  if (order) p.channel = next_word(rest);
  if (!sent && !received && !order) {
    if (what != "open" && what != "closed")
      refuse(file, line, "after the time stands >, <, =, open or closed");
    p.kind = what == "open" ? Cassette::Kind::kOpened : Cassette::Kind::kClosed;
    return p;
  }
  p.kind = sent ? Cassette::Kind::kSent : received ? Cassette::Kind::kReceived : Cassette::Kind::kOrder;
  for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
    const int high = digit(word[0]), low = word.size() == 2 ? digit(word[1]) : -1;
    if (high < 0 || low < 0) refuse(file, line, "'" + std::string(word) + "' is no byte of two hex digits");
    p.bytes.push_back(std::byte(high << 4 | low));
  }
  if (p.bytes.empty() && p.channel != "stop") refuse(file, line, "has no bytes");
  return p;
}

}  // namespace

std::string cassette_head(std::string_view node, std::string_view remark, std::string_view config_toml) {
  std::string text = std::string(kHead) + std::string(node) + "\n# " + std::string(remark) + "\n";
  while (!config_toml.empty()) {
    const std::string_view line = config_toml.substr(0, config_toml.find('\n'));
    config_toml.remove_prefix(std::min(config_toml.size(), line.size() + 1));
    text += "# " + std::string(kConfig) + std::string(line) + "\n";
  }
  return text;
}

std::string config_of(const Cassette& cassette) {
  std::string config;
  for (const std::string& remark : cassette.remarks)
    if (remark.starts_with(kConfig)) config += remark.substr(kConfig.size()) + "\n";
  return config;
}

std::string cassette_line(Cassette::Kind kind, double ms, std::span<const std::byte> bytes) {
  using Kind = Cassette::Kind;
  const std::string line = time_of(ms);
  if (kind == Kind::kOpened) return line + "open\n";
  if (kind == Kind::kClosed) return line + "closed\n";
  return line + (kind == Kind::kSent ? ">" : "<") + shown(bytes) + "\n";
}

std::string shown(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte b : bytes) text += b >= std::byte{0x20} && b < std::byte{0x7f} ? char(b) : '.';
  return hex_of(bytes) + " |" + text + "|";
}

std::string cassette_order(std::string_view channel, double ms, std::span<const std::byte> message,
                           std::string_view text) {
  return time_of(ms) + "= " + std::string(channel) + hex_of(message) + " |" + std::string(text) + "|\n";
}

Cassette parse_cassette(std::string_view text, const std::string& file) {
  if (text.size() > kLongestCassette) refuse(file, 1, "a cassette has at most 256 MiB");
  Cassette c;
  double last_ms = 0.0;
  for (int number = 1; !text.empty(); ++number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    while (line.ends_with('\r')) line.remove_suffix(1);
    if (number == 1) {
      if (!line.starts_with(kHead) || line.size() == kHead.size())
        refuse(file, 1, "is no cassette: its first line must be '" + std::string(kHead) + "NODE'");
      c.node = line.substr(kHead.size());
      if (c.node.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") != std::string::npos)
        refuse(file, 1, "'" + c.node + "' is no instrument's name");
      continue;
    }
    if (line.empty()) continue;
    if (line.starts_with("# ")) {
      c.remarks.emplace_back(line.substr(2));
    } else {
      c.pieces.push_back(piece_of(line, file, number));
      if (c.pieces.back().ms < last_ms) refuse(file, number, "is earlier than the line before");
      last_ms = c.pieces.back().ms;
    }
  }
  if (c.node.empty()) refuse(file, 1, "is empty");
  return c;
}

}  // namespace firn
