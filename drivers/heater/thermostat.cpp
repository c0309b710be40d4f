#include "drivers/heater/thermostat.h"

#include <cmath>
#include <limits>

namespace firn::drivers::thermostat {
namespace {

constexpr std::string_view kAsk = "T?", kOpen = "OPEN";

Request to_request(LineWriter& line, Repeat repeat, std::uint16_t tag) {
  Request r;
  r.append(line.finish(0));
  r.repeat = repeat;
  r.tag = tag;
  return r;
}

}  // namespace

std::optional<Reading> parse_reading(std::string_view text) {
  WordReader words(text, ',');
  if (words.word() != "T") return std::nullopt;
  Reading r;
  for (double& celsius : r.celsius) {
    const std::string_view before = words.rest();
    if (WordReader look(before, ','); look.word() == kOpen) {
      celsius = std::numeric_limits<double>::quiet_NaN();
      words.word();
    } else {
      celsius =
          double(words.number(std::int64_t(kLowest_degC * 100), std::int64_t(kHighest_degC * 100))) / 100.0;
    }
  }
  const std::int64_t relays = words.number(0, (1 << kChannels) - 1);
  for (std::size_t c = 0; c < std::size_t(kChannels); ++c) r.heating[c] = relays >> c & 1;
  return words.good() && words.at_end() ? std::optional(r) : std::nullopt;
}

void put(LineWriter& line, const SetPoint& set) {
  line.text("S,").number(set.channel).text(",").number(set.c100);
}

Request read_request(std::uint16_t tag) {
  LineWriter line;
  line.text(kAsk);
  return to_request(line, Repeat::kRead, tag);
}

Request set_request(const SetPoint& set, std::uint16_t tag) {
  LineWriter line;
  put(line, set);
  return to_request(line, Repeat::kSetup, tag);
}

ThermostatDialect::ThermostatDialect() : LineDialect('\n', LineWriter::kLongest) {
  timeouts.reply_us = 500'000;
  timeouts.read_us = 100'000;
  timeouts.quiet_us = 150'000;
  timeouts.lock_us = 5'000'000;
}

std::optional<std::string_view> ThermostatDialect::body(std::string_view line) const {
  return checked_text(line, 0);
}

bool ThermostatDialect::answers(std::string_view text, const Request& asked) const {
  const std::optional<std::string_view> question = checked_text(asked.text(), 0);
  return text.starts_with("E,") || (*question == kAsk ? parse_reading(text).has_value() : text == *question);
}

Request ThermostatDialect::probe() const { return read_request(0); }

LinkProbe link_probe() {
  return {"a heater's read-out box", std::string(read_request(0).text()),
          [](std::string_view s) { return is_whole_reply(ThermostatDialect(), read_request(0), s); }};
}

}  // namespace firn::drivers::thermostat
