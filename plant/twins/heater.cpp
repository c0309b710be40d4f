#include "plant/twins/heater.h"

#include "drivers/heater/thermostat.h"

namespace firn::plant {

using namespace drivers::thermostat;

void HeaterTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (line_.size() < 64) line_.push_back(c);
    if (c != '\n') continue;
    drivers::LineWriter out;
    Heat& heat = wires_.nature().heat();
    const auto text = drivers::checked_text(line_, 0);
    const auto set = text ? parse_set_point(*text) : std::nullopt;
    if (!text) {
      out.text("E,1");
    } else if (*text == "T?") {
      heat.advance(now_us);
      Reading reading;
      for (int n = 0; n < kChannels; ++n) {
        reading.celsius[std::size_t(n)] = heat.shown_degC(n);
        reading.heating[std::size_t(n)] = heat.relay(n);
      }
      put(out, reading);
    } else if (set && set->c100 <= 4500) {
      heat.advance(now_us);
      heat.set(set->channel - 1, set->c100 * 0.01);
      wires_.note(now_us, port_, DeviceEvent::kHeaterSet,
                  std::int64_t(set->channel) * 100'000 + set->c100 + 10'000);
      put(out, *set);
    } else {
      out.text(text->starts_with("S,") ? "E,3" : "E,2");
    }
    link_.reply(out.finish(0), now_us);
    line_.clear();
  }
}

// The thermostats are apart from the box: they go on.
void HeaterTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  line_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void HeaterTwin::trip(std::int64_t now_us, std::int64_t code) {
  Heat& heat = wires_.nature().heat();
  heat.advance(now_us);
  for (int n = 0; n < kChannels; ++n) {
    if (code == 0 || code == n + 1) heat.break_heater(n, code != 0);
    if (code == 0 || code == n + 4) heat.open_thermocouple(n, code != 0);
    if (code == 0 || code == n + 7) heat.stick_relay(n, code != 0);
    if (code == 0 || code == n + 10) heat.freeze_reading(n, code != 0);
  }
}

}  // namespace firn::plant
