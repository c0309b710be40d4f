#include "drivers/link/line_cleaner.h"

#include <cstdio>

namespace firn::drivers {
namespace {

// RFC 854: IAC, then a command of F0h..FEh; WILL, WONT, DO and DONT have an option behind them; SB … IAC SE
// is a subnegotiation.
constexpr std::uint8_t kIac = 0xFF, kFirstCommand = 0xF0, kSe = 0xF0, kSb = 0xFA, kWill = 0xFB;
constexpr std::size_t kMostShown = 80;

}  // namespace

void LineCleaner::clean(std::span<const std::byte> bytes, char end, std::vector<std::byte>& out) {
  for (const std::byte b : bytes)
    if (!take_telnet(std::uint8_t(b), end, out)) take_text(char(b), end, out);
}

bool LineCleaner::take_telnet(std::uint8_t byte, char end, std::vector<std::byte>& out) {
  switch (telnet_) {
    case Telnet::kText:
      if (byte != kIac) return false;
      telnet_ = Telnet::kCommand;
      return true;
    case Telnet::kCommand:
      telnet_ = byte == kSb ? Telnet::kSub : byte >= kWill ? Telnet::kOption : Telnet::kText;
      if (byte >= kFirstCommand && byte != kIac) return true;
      telnet_ = Telnet::kText;  // no command: damage, which must be seen
      take_text(char(kIac), end, out);
      return byte == kIac;
    case Telnet::kOption:
      telnet_ = Telnet::kText;
      return true;
    case Telnet::kSub:
      if (byte == kIac) telnet_ = Telnet::kSubCommand;
      return true;
    case Telnet::kSubCommand:
      telnet_ = byte == kSe ? Telnet::kText : Telnet::kSub;
      return true;
  }
  return false;
}

void LineCleaner::take_text(char c, char end, std::vector<std::byte>& out) {
  const auto put = [&](char one) { out.push_back(std::byte(one)); };
  const bool other_end = c == '\r' || c == '\n';
  if (c == end || (other_end && (end == '\r' || end == '\n'))) {
    if (!at_start_) put(end);
    *this = {};
    return;
  }
  if (c == '\0' || c == '\b' || other_end) {
    if (!at_start_) padding_ += c;
    return;
  }
  if (c == ' ') {
    if (at_start_) return;
    padding_.clear();
    blank_before_ = true;
    put(c);
    return;
  }
  if (!at_start_ && !blank_before_)
    for (const char kept : padding_) put(kept);
  padding_.clear();
  at_start_ = blank_before_ = false;
  put(c);
}

std::string cleaned(std::string_view heard, char end) {
  std::vector<std::byte> out;
  LineCleaner().clean(std::as_bytes(std::span(heard.data(), heard.size())), end, out);
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

std::string shown_line(std::string_view bytes) {
  std::string text = "'";
  for (const char c : bytes.substr(0, kMostShown)) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "\\x%02x", unsigned(std::uint8_t(c)));
    text += c >= 0x20 && c < 0x7f ? std::string(1, c) : std::string(hex);
  }
  return text + (bytes.size() > kMostShown ? "…'" : "'");
}

}  // namespace firn::drivers
