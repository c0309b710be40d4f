// Twin simulates one instrument behind its port; Wires carries hardware lines from the twins to the world.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "plant/record/archive.h"
#include "plant/record/record.h"
#include "plant/twins/link.h"

namespace firn::plant {

/// Hardware lines and notes, from a twin to the world.
class Wires {
 public:
  virtual ~Wires() = default;
  /// A pulse of the stage's position-synchronised output of `axis` at the exact crossing.
  virtual void pulse(int axis, std::int64_t t_us, const double position_mm[3],
                     const double velocity_mm_s[3]) = 0;
  virtual void softtrigger(std::int64_t t_us, Port jet, int droplets) = 0;  ///< the jet fires of itself
  virtual void lamp(std::int64_t t_us, LampEvent event, double dose_s) = 0;
  virtual void link_closed(std::int64_t t_us, Port port) = 0;  ///< by the instrument
  virtual void note(std::int64_t t_us, Port port, DeviceEvent event, std::int64_t value) = 0;
};

class Twin {
 public:
  Twin(Port port, TwinLink link) : port_(port), link_(std::move(link)) {}
  virtual ~Twin() = default;

  virtual void connected(std::int64_t) {}
  virtual void disconnected(std::int64_t) {}
  /// Takes bytes at their arrival.
  virtual void take(std::span<const std::byte> bytes, std::int64_t now_us) = 0;
  /// Time of the device's own next event (kNever: no event pending), and its execution.
  virtual std::int64_t next_device_us() const = 0;
  virtual void device_event(std::int64_t now_us) = 0;
  virtual bool device_event_replies() const {
    return false;
  }  ///< the next one may send bytes or close the port
  virtual void reboot(std::int64_t now_us) = 0;
  virtual void trip(std::int64_t, std::int64_t) {}  ///< 0: the fault ends
  virtual void io(Archive& a) = 0;

  std::int64_t next_inner_us() const { return std::min(link_.next_arrival_us(), next_device_us()); }
  std::int64_t next_visible_us() const {
    const std::int64_t inner = device_event_replies() ? next_inner_us() : link_.next_arrival_us();
    return std::min(inner, link_.next_send_us());
  }
  /// Executes the one next inner event.
  void step() {
    const std::int64_t arrival_us = link_.next_arrival_us(), device_us = next_device_us();
    if (device_us <= arrival_us) return device_event(device_us);
    const std::byte b = link_.pop_arrival();
    if (!link_.hung()) take({&b, 1}, arrival_us);
  }
  TwinLink& link() { return link_; }
  const TwinLink& link() const { return link_; }

 protected:
  Port port_;
  TwinLink link_;
  std::uint32_t boot_count_ = 1;
};

}  // namespace firn::plant
