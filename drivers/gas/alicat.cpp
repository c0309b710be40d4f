#include "drivers/gas/alicat.h"

#include <algorithm>
#include <charconv>
#include <cstdio>

namespace firn::drivers::alicat {
namespace {

constexpr std::size_t kLongestLine = 160, kLongestInfo = 1200;
constexpr std::size_t kLongestNumber = 12;
constexpr std::string_view kLastInfo = " M09 ";
constexpr std::string_view kCodes[] = {"ADC", "EXH", "HLD", "LCK", "MOV", "OPL",
                                       "OVR", "POV", "TOV", "VOV", "TMF"};

std::string_view next_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

/// "+014.70" and how much its last digit is.
bool number(std::string_view word, double& value, double& resolution) {
  if (word.size() < 2 || (word[0] != '+' && word[0] != '-')) return false;
  const std::string_view digits = word.substr(1);
  if (digits.size() > kLongestNumber) return false;
  if (digits.find_first_not_of("0123456789.") != std::string_view::npos) return false;
  const auto r = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (r.ec != std::errc() || r.ptr != digits.data() + digits.size()) return false;
  if (word[0] == '-') value = -value;
  const std::size_t point = digits.find('.');
  resolution = 1.0;
  for (std::size_t n = point; n != std::string_view::npos && n + 1 < digits.size(); ++n) resolution /= 10.0;
  return true;
}

Request line_of(const std::string& text, Repeat repeat, Format format, Unit unit, std::uint16_t tag) {
  Request r;
  r.append(text + "\r");
  r.repeat = repeat;
  r.format = format;
  r.argument = unit.id;
  r.tag = tag;
  return r;
}

/// The dialect's text with the unit in its place.
std::string named(const std::string& text, Unit unit) {
  std::string out;
  for (const char c : text)
    if (c == '@')
      out += std::string(1, unit.id) + (unit.dollars ? "$$" : "");
    else
      out += c;
  return out;
}

}  // namespace

std::string names_of(std::uint16_t codes) {
  std::string text;
  for (std::size_t n = 0; n < std::size(kCodes); ++n)
    if (codes & 1u << n) text += (text.empty() ? "" : " ") + std::string(kCodes[n]);
  return text;
}

std::optional<Reading> parse_reading(std::string_view line) {
  Reading r;
  const std::string_view unit = next_word(line);
  if (unit.size() != 1 || unit[0] < 'A' || unit[0] > 'Z') return std::nullopt;
  r.unit = unit[0];
  double values[6] = {}, resolution = 0.0;
  std::size_t count = 0;
  std::string_view word = next_word(line);
  for (double value = 0.0; number(word, value, resolution); word = next_word(line)) {
    if (count == std::size(values)) return std::nullopt;
    values[count++] = value;
    if (count == 5) r.resolution = resolution;
  }
  if (count < 5 || word.empty()) return std::nullopt;
  r.pressure = values[0];
  r.temperature_degC = values[1];
  r.volume_flow = values[2];
  r.mass_flow = values[3];
  r.set_point = values[4];
  r.gas = word;
  for (word = next_word(line); !word.empty(); word = next_word(line))
    if (const auto known = std::ranges::find(kCodes, word); known != std::end(kCodes))
      r.codes = std::uint16_t(r.codes | 1u << (known - std::begin(kCodes)));
  return r;
}

Request poll_request(Unit unit, std::uint16_t tag) {
  return line_of(std::string(1, unit.id), Repeat::kRead, kData, unit, tag);
}

Request version_request(Unit unit, const GasDialect& texts, std::uint16_t tag) {
  return line_of(named(texts.version, {unit.id, false}), Repeat::kRead, kVersion, unit, tag);
}

Request info_request(Unit unit, const GasDialect& texts, std::uint16_t tag) {
  return line_of(named(texts.manufacturer, unit), Repeat::kRead, kInfo, unit, tag);
}

// Twice is as good as once: the flow goes to the same set point.
Request set_request(Unit unit, double value, const GasDialect& texts, std::uint16_t tag) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f", texts.decimals, value);
  return line_of(named(texts.set_point, unit) + text, Repeat::kSetup, kData, unit, tag);
}

std::string_view text_of(std::span<const std::byte> frame) {
  std::string_view text(reinterpret_cast<const char*>(frame.data()), frame.size());
  while (!text.empty() && (text.back() == '\r' || text.back() == '\n')) text.remove_suffix(1);
  return text;
}

bool is_refusal(std::string_view line) {
  std::string_view word = next_word(line);
  if (word.size() == 1 && word != "?") word = next_word(line);
  return word == "?";
}

AlicatDialect::AlicatDialect() {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 150'000;
  timeouts.quiet_us = 150'000;
  timeouts.lock_us = 3'000'000;
}

Frame AlicatDialect::frame(std::span<const std::byte> buffer, const Request* awaited) const {
  const std::string_view all(reinterpret_cast<const char*>(buffer.data()), buffer.size());
  const bool list = awaited && awaited->format == kInfo;
  std::size_t end = all.find('\r');
  if (list && !is_refusal(all.substr(0, end))) {
    const std::size_t last = all.find(kLastInfo);
    end = last == std::string_view::npos ? last : all.find('\r', last);
  }
  if (end == std::string_view::npos)
    return all.size() > (list ? kLongestInfo : kLongestLine) ? Frame{Frame::Kind::kCorrupt, all.size()}
                                                             : Frame{};
  const std::size_t size = end + 1;
  if (!awaited) return {Frame::Kind::kUnsolicited, size};
  const std::string_view line = text_of(buffer.first(size));
  if (is_refusal(line)) return {Frame::Kind::kReply, size};
  const bool ours = line.size() > 2 && line[0] == char(awaited->argument) && line[1] == ' ';
  const bool good = ours && (list || parse_reading(line).has_value() == (awaited->format == kData));
  return {good ? Frame::Kind::kReply : Frame::Kind::kCorrupt, size};
}

Request AlicatDialect::probe() const { return poll_request({probed, false}, 0); }

LinkProbe link_probe() {
  return {"an Alicat flow controller", std::string(poll_request({}, 0).text()), [](std::string_view s) {
            return s.ends_with('\r') && parse_reading(s.substr(0, s.size() - 1)).has_value();
          }};
}

}  // namespace firn::drivers::alicat
