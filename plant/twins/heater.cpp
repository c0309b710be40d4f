#include "plant/twins/heater.h"

#include <algorithm>
#include <cmath>

#include "plant/twins/lines.h"

namespace firn::plant {

namespace {

constexpr int kHeaters = 3;
constexpr std::int64_t kOff_cdegC = -5000;  ///< set point, 0.01 degC
constexpr const char *kDamaged = "E,1", *kUnknown = "E,2", *kHeaterRefused = "E,3";

std::string reading(const Heat& heat) {
  std::string text = "T";
  int relays = 0;
  for (int n = 0; n < kHeaters; ++n) {
    const double degC = heat.shown_degC(n);
    text += std::isnan(degC) ? ",OPEN" : ',' + std::to_string(std::lround(degC * 100.0));
    relays |= int(heat.relay(n)) << n;
  }
  return text + ',' + std::to_string(relays);
}

}  // namespace

std::string HeaterTwin::execute(std::string_view command, std::int64_t now_us) {
  Heat& heat = wires_.heat();
  if (command == "T?") {
    heat.advance(now_us);
    return reading(heat);
  }
  if (!command.starts_with("S,")) return kUnknown;
  std::string arguments(command.substr(2));
  if (arguments.find(' ') != arguments.npos) return kHeaterRefused;
  std::replace(arguments.begin(), arguments.end(), ',', ' ');
  Words words(arguments);
  const auto channel = words.integer(1, kHeaters),
             cdegC = words.integer(kOff_cdegC, std::llround(highest_degC_ * 100.0));
  if (!words.good() || words.more()) return kHeaterRefused;
  heat.advance(now_us);
  heat.set(int(channel) - 1, double(cdegC) * 0.01);
  wires_.note(now_us, port_, DeviceEvent::kHeaterSet, channel * 100'000 + cdegC + 10'000);
  return std::string(command);
}

void HeaterTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    const char c = char(b);
    if (line_.size() < 64) line_.push_back(c);
    if (c != '\n') continue;
    const auto command = unsealed(line_);
    link_.reply(sealed(command ? execute(*command, now_us) : kDamaged), now_us);
    line_.clear();
  }
}

// The thermostats are apart from the box: they go on.
void HeaterTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  line_.clear();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void trip_heaters(Heat& heat, std::int64_t now_us, std::int64_t code) {
  heat.advance(now_us);
  for (int n = 0; n < kHeaters; ++n) {
    if (code == 0 || code == n + 1) heat.break_heater(n, code != 0);
    if (code == 0 || code == n + 4) heat.open_thermocouple(n, code != 0);
    if (code == 0 || code == n + 7) heat.stick_relay(n, code != 0);
    if (code == 0 || code == n + 10) heat.freeze_reading(n, code != 0);
  }
}

}  // namespace firn::plant
