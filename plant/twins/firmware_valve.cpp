#include "plant/twins/firmware_valve.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "firmware/valve/pulses.h"

namespace firn::plant {
namespace {

FiringEnd end_of(std::uint8_t why) {
  switch (why) {
    case VALVE_DISARMED:
      return FiringEnd::kDisarmed;
    case VALVE_ABORTED:
      return FiringEnd::kAborted;
    case VALVE_DISABLED:
      return FiringEnd::kDisabled;
    case VALVE_WATCHDOG:
    case VALVE_TOO_HOT:
      return FiringEnd::kWatchdog;
    default:
      return FiringEnd::kThrough;
  }
}

}  // namespace

FirmwareValveTwin::FirmwareValveTwin(int valve, const IceValveParams& params, double host_scale,
                                     IceWires& wires)
    : ValveBox(valve == 0 ? Port::kValveA : Port::kValveB, TwinLink(10.0e6 / params.baud, 0)),
      valve_(valve),
      params_(params),
      host_scale_(host_scale),
      wires_(wires) {
  boot(0, 0);
}

void FirmwareValveTwin::boot(std::uint8_t reset_cause, std::int64_t now_us) {
  valve_init(&firmware_, std::uint16_t(boot_count_), reset_cause);
  firmware_.pause_steps = std::uint16_t(std::min(65000.0, firmware_.pause_steps * host_scale_));
  firmware_.silence_steps = std::uint32_t(firmware_.silence_steps * host_scale_);
  booted_us_ = now_us;
  step_ = 0;
  trigger_at_us_ = kNever;
  fires_ = was_armed_ = false;
}

// The microsecond in which a step of the firmware's clock is over.
std::int64_t FirmwareValveTwin::time_of(std::int64_t step) const {
  return booted_us_ +
         std::int64_t(std::ceil(double(step) * double(VALVE_STEP_US) * (1.0 + params_.clock_ppm * 1e-6))) + 1;
}

void FirmwareValveTwin::run_until(std::int64_t now_us) {
  while (time_of(step_) <= now_us) {
    const std::int64_t at_us = time_of(step_++);
    valve_step(&firmware_);
    if (fires_ && firmware_.state != VALVE_FIRING) ended(at_us);
  }
}

void FirmwareValveTwin::take(std::span<const std::byte> bytes, std::int64_t now_us) {
  run_until(now_us);
  for (const std::byte b : bytes) {
    valve_receive(&firmware_, std::uint8_t(b));
    look(now_us);
    if (firmware_.reply_size > 0)
      link_.reply({reinterpret_cast<const char*>(firmware_.reply), firmware_.reply_size}, now_us);
  }
}

void FirmwareValveTwin::look(std::int64_t now_us) {
  if (never_arms_ && firmware_.state == VALVE_ARMED) firmware_.state = VALVE_LOADED;
  if (firmware_.state == VALVE_ARMED && !was_armed_)
    wires_.note(now_us, port_, DeviceEvent::kValveArmed, firmware_.path);
  was_armed_ = firmware_.state == VALVE_ARMED;
  if (fires_ && firmware_.state != VALVE_FIRING) ended(now_us);
  if (!fires_ && firmware_.state == VALVE_FIRING) begun(now_us);
}

// The list is nature's from here on: its first tick is the firmware's next step.
void FirmwareValveTwin::begun(std::int64_t now_us) {
  Firing list;
  list.path = firmware_.path;
  list.tick_s = firmware_.tick_us * 1e-6 * (1.0 + params_.clock_ppm * 1e-6);
  list.pulse_s = firmware_.pulse_us * 1e-6;
  for (std::uint32_t n = 0; n < firmware_.entries; ++n)
    list.ticks.push_back(firmware_.spits ? std::uint16_t(n) : firmware_.ticks[n]);
  fires_ = true;
  triggered_us_ = now_us;
  wires_.nature().trigger_valve(valve_, double(time_of(step_) - 1) * 1e-6, std::move(list));
}

void FirmwareValveTwin::ended(std::int64_t now_us) {
  fires_ = false;
  const Firing f = wires_.nature().close_valve(valve_);
  wires_.fired({triggered_us_,
                f.first_us,
                f.last_us,
                now_us,
                f.volume_mm3,
                f.path,
                std::uint32_t(f.ticks.size()),
                std::uint32_t(f.next),
                std::uint8_t(valve_),
                end_of(firmware_.end),
                {}});
}

void FirmwareValveTwin::signal(std::int64_t t_us) {
  run_until(t_us);
  trigger_at_us_ = t_us + std::llround(params_.trigger_delay_s * 1e6);
}

void FirmwareValveTwin::disable(std::int64_t t_us) {
  run_until(t_us);
  trigger_at_us_ = kNever;
  valve_disable(&firmware_);
  look(t_us);
}

std::int64_t FirmwareValveTwin::next_device_us() const {
  std::int64_t next = trigger_at_us_;
  if (firmware_.state == VALVE_ARMED && firmware_.wait_steps > 0)
    next = std::min(next, time_of(step_ + firmware_.wait_steps - 1));
  if (firmware_.state == VALVE_FIRING) {
    const std::int64_t last = firmware_.entries == 0 ? 0
                              : firmware_.spits      ? firmware_.entries - 1
                                                     : firmware_.ticks[firmware_.entries - 1];
    const std::int64_t left_us =
        last * firmware_.tick_us + firmware_.pulse_us - std::int64_t(firmware_.since_us);
    const std::int64_t steps = std::max<std::int64_t>(1, (left_us + VALVE_STEP_US - 1) / VALVE_STEP_US);
    const std::int64_t silent = std::int64_t(firmware_.silence_steps) - firmware_.heard_steps;
    next = std::min(next, time_of(step_ + std::max<std::int64_t>(0, std::min(steps, silent - 1))));
  }
  return next;
}

void FirmwareValveTwin::device_event(std::int64_t now_us) {
  run_until(now_us);
  if (now_us == trigger_at_us_) {
    trigger_at_us_ = kNever;
    valve_trigger(&firmware_);
  }
  look(now_us);
}

void FirmwareValveTwin::trip(std::int64_t now_us, std::int64_t code) {
  run_until(now_us);
  never_arms_ = code == 5;
  if (code == 4) {
    if (firmware_.state == VALVE_FIRING) valve_end(&firmware_, VALVE_DISARMED, VALVE_DONE);
    if (firmware_.state == VALVE_ARMED) firmware_.state = VALVE_LOADED;
    firmware_.wait_steps = 0;
    look(now_us);
  }
  trip_line(wires_.nature(), valve_, code);
}

void FirmwareValveTwin::reboot(std::int64_t now_us) {
  run_until(now_us);
  if (fires_) {
    ended(now_us);
  }
  ++boot_count_;
  boot(1, now_us);
  wires_.note(now_us, port_, DeviceEvent::kRebooted, boot_count_);
}

void FirmwareValveTwin::io(Archive& a) {
  std::string image(sizeof firmware_, '\0');
  std::memcpy(image.data(), &firmware_, sizeof firmware_);
  a.all(boot_count_, image, booted_us_, step_, trigger_at_us_, triggered_us_, fires_, never_arms_, was_armed_,
        link_);
  if (!a.loading()) return;
  const auto damaged = [] { throw std::runtime_error("world state: a valve's firmware is damaged"); };
  if (image.size() != sizeof firmware_) damaged();
  for (const std::size_t flag : {offsetof(::valve, known), offsetof(::valve, spits)})
    if (std::uint8_t(image[flag]) > 1) damaged();
  std::memcpy(&firmware_, image.data(), sizeof firmware_);
  const ::valve& v = firmware_;
  if (v.frame_size >= VALVE_MAX_FRAME || v.reply_size > VALVE_MAX_REPLY || v.answer_size > VALVE_MAX_REPLY ||
      v.held > VALVE_MAX_ENTRIES || (!v.spits && v.entries > VALVE_MAX_ENTRIES) || v.state > VALVE_FAULT)
    damaged();
}

}  // namespace firn::plant
