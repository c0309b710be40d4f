#include "plant/twins/firmware_heater.h"

#include <cmath>
#include <stdexcept>

namespace firn::plant {
namespace {

constexpr std::int64_t kTick_us = HEATER_TICK_MS * 1000;
constexpr double kForced_degC = 1000.0;  // nature's own thermostat never switches at such a set point

}  // namespace

std::uint32_t converted(double degC) {
  constexpr std::uint32_t kFaultAndOpen = 0x10001;
  constexpr std::uint32_t kTemperature = 0x3FFF;  // 14 bits
  if (std::isnan(degC)) return kFaultAndOpen;
  return (std::uint32_t(std::lround(degC * 4.0)) & kTemperature) << 18;
}

FirmwareHeaterTwin::FirmwareHeaterTwin(HeaterWires& wires, double highest_degC)
    : Twin(Port::kHeater, TwinLink(10.0e6 / 9600.0, 2000)),
      wires_(wires),
      highest_cdegC_(std::int32_t(std::lround(highest_degC * 100.0))) {
  for (int n = 0; n < HEATER_CHANNELS; ++n)
    kept_cdegC_[std::size_t(n)] = std::int32_t(std::lround(wires.heat().set_degC(n) * 100.0));
  start();
}

void FirmwareHeaterTwin::start() {
  heater_init(&firmware_, highest_cdegC_);
  for (std::size_t n = 0; n < kept_cdegC_.size(); ++n)
    heater_restore(&firmware_, std::uint8_t(n), kept_cdegC_[n]);
}

void FirmwareHeaterTwin::device_event(std::int64_t now_us) {
  tick_us_ = now_us + kTick_us;
  Heat& heat = wires_.heat();
  heat.advance(now_us);
  for (int n = 0; n < HEATER_CHANNELS; ++n)
    heater_read(&firmware_, std::uint8_t(n), converted(heat.shown_degC(n)));
  heater_tick(&firmware_);
  for (int n = 0; n < HEATER_CHANNELS; ++n)
    heat.set(n, firmware_.channel[n].relay ? kForced_degC : -kForced_degC);
}

void FirmwareHeaterTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  for (const std::byte b : bytes) {
    heater_receive(&firmware_, std::uint8_t(b));
    if (firmware_.reply_size == 0) continue;
    link_.reply({reinterpret_cast<const char*>(firmware_.reply), firmware_.reply_size}, now_us);
    if (!firmware_.changed) continue;
    firmware_.changed = false;
    for (std::size_t n = 0; n < kept_cdegC_.size(); ++n) {
      const std::int32_t cdegC = firmware_.channel[n].set_cdegC;
      if (cdegC == kept_cdegC_[n]) continue;
      kept_cdegC_[n] = cdegC;
      wires_.note(now_us, port_, DeviceEvent::kHeaterSet, std::int64_t(n + 1) * 100'000 + cdegC + 10'000);
    }
  }
}

void FirmwareHeaterTwin::reboot(std::int64_t now_us) {
  ++boot_count_;
  start();
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void FirmwareHeaterTwin::trip(std::int64_t now_us, std::int64_t code) {
  trip_heaters(wires_.heat(), now_us, code);
}

void FirmwareHeaterTwin::io(Archive& a) {
  std::string line(reinterpret_cast<const char*>(firmware_.line), firmware_.line_size);
  a.all(boot_count_, line, kept_cdegC_, tick_us_, link_);
  for (heater_channel& c : firmware_.channel)
    a.all(c.set_cdegC, c.shown_cdegC, c.ticks_since_reading, c.open, c.cut_out, c.relay);
  if (!a.loading()) return;
  if (line.size() >= HEATER_MAX_LINE + 1u)
    throw std::runtime_error("world state: the heaters' firmware is damaged");
  std::copy(line.begin(), line.end(), firmware_.line);
  firmware_.line_size = std::uint8_t(line.size());
}

}  // namespace firn::plant
