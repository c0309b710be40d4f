// The read-out box's side of its lines (drivers/heater/thermostat.h).
#pragma once

#include <cmath>

#include "drivers/heater/thermostat.h"

namespace firn::drivers::thermostat {

inline void put(LineWriter& line, const Reading& r) {
  line.text("T");
  int relays = 0;
  for (std::size_t c = 0; c < std::size_t(kChannels); ++c) {
    line.text(",");
    if (std::isnan(r.celsius[c]))
      line.text("OPEN");
    else
      line.number(std::llround(r.celsius[c] * 100.0));
    relays |= int(r.heating[c]) << c;
  }
  line.text(",").number(relays);
}

inline std::optional<SetPoint> parse_set_point(std::string_view text) {
  WordReader words(text, ',');
  if (words.word() != "S") return std::nullopt;
  SetPoint set;
  set.channel = int(words.number(1, kChannels));
  set.c100 = std::int32_t(words.number(kOff_c100, std::int64_t(kHighest_degC * 100)));
  return words.good() && words.at_end() ? std::optional(set) : std::nullopt;
}

}  // namespace firn::drivers::thermostat
