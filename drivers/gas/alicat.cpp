#include "drivers/gas/alicat.h"

#include <algorithm>
#include <cstdio>

#include "core/options/number.h"

namespace firn::drivers::alicat {
namespace {

constexpr std::size_t kLongestLine = 160, kLongestInfo = 1200;
constexpr std::size_t kLongestNumber = 12;
constexpr std::size_t kMostNumbers = 7;  // with two totals
constexpr std::string_view kLastInfo = " M09 ";
constexpr std::string_view kCodes[] = {"ADC", "EXH", "HLD", "LCK", "MOV", "OPL",
                                       "OVR", "POV", "TOV", "VOV", "TMF"};

std::string_view next_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

/// "+014.70" as it is shown.
struct Number {
  double value = 0.0;
  int decimals = 0;
  bool is_signed = false;
};

std::optional<Number> number(std::string_view word) {
  Number n;
  n.is_signed = word.starts_with('+') || word.starts_with('-');
  const std::string_view digits = word.substr(n.is_signed ? 1 : 0);
  if (digits.empty() || digits.size() > kLongestNumber) return std::nullopt;
  if (digits.find_first_not_of("0123456789.") != std::string_view::npos) return std::nullopt;
  if (digits.front() == '.' || digits.back() == '.') return std::nullopt;
  const std::optional<double> value = whole_number<double>(digits);
  if (!value) return std::nullopt;
  n.value = word[0] == '-' ? -*value : *value;
  if (const std::size_t point = digits.find('.'); point != std::string_view::npos)
    n.decimals = int(digits.size() - point - 1);
  return n;
}

/// A damaged digit can cut a number into two, which would move all that follow by one place: there is no
/// checksum. Such a frame has other signs or decimals than firmware gives.
bool in_their_places(const Number (&n)[kMostNumbers], std::size_t count) {
  if (count < 5) return false;
  const Number &pressure = n[0], &temperature = n[1], &volume_flow = n[2], &mass_flow = n[3],
               &set_point = n[4];
  if (pressure.decimals == 0 || temperature.decimals == 0) return false;
  if (temperature.is_signed != pressure.is_signed || volume_flow.is_signed != pressure.is_signed ||
      mass_flow.is_signed != pressure.is_signed)
    return false;
  return set_point.decimals == mass_flow.decimals && (pressure.is_signed || count == 5);
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

// By place: unit, five numbers, totals if it counts any, gas, codes. Firmware before 8v writes the sign of a
// negative set point alone [C].
std::optional<Reading> parse_reading(std::string_view line) {
  Reading r;
  const std::string_view unit = next_word(line);
  if (unit.size() != 1 || unit[0] < 'A' || unit[0] > 'Z') return std::nullopt;
  r.unit = unit[0];
  Number numbers[kMostNumbers];
  std::size_t count = 0;
  std::string_view word = next_word(line);
  for (auto n = number(word); n; n = number(word)) {
    if (count == std::size(numbers)) return std::nullopt;
    numbers[count++] = *n;
    word = next_word(line);
  }
  if (word.empty() || !in_their_places(numbers, count)) return std::nullopt;
  r.pressure = numbers[0].value;
  r.temperature_degC = numbers[1].value;
  r.volume_flow = numbers[2].value;
  r.mass_flow = numbers[3].value;
  r.set_point = numbers[4].value;
  r.resolution = 1.0;
  for (int n = 0; n < numbers[4].decimals; ++n) r.resolution /= 10.0;
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
  std::string_view text = drivers::text_of(frame);
  if (text.ends_with('\r')) text.remove_suffix(1);
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
  const std::string_view all = drivers::text_of(buffer);
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
  return {"an Alicat flow controller", std::string(poll_request({}, 0).text()),
          [](std::string_view s) {
            return s.ends_with('\r') && parse_reading(s.substr(0, s.size() - 1)).has_value();
          },
          '\r'};
}

}  // namespace firn::drivers::alicat
