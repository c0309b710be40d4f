// ProfilerTwin simulates the laser profiler Keyence LJ-V7000 over TCP: one profile per external trigger,
// kept in its memory; the newest one, or several by number, on request.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string>

#include "plant/config/world_config.h"
#include "plant/twins/profile_sensor.h"

namespace firn::plant {

/// Request: u32 bytes that follow, u32 0x00F00001, u32 0, u32 body bytes, u8 command, 3 zeros, arguments;
/// little endian. Answers 0x39 (change program) and 0x42 (u32 0, u8 bank, u8 0 newest, 1 oldest, 2 by number,
/// u16 0, u32 number, u8 profiles, u8 1 = forget those read and the older ones). Reply: u32 bytes that
/// follow, 0x00F00001, u32 header code, u32 body bytes, u8 command, u8 code, 6 zeros, u32 program, and for
/// 0x42 u32 numbers newest, oldest, first of this reply, u8 profiles, the form of the points, and the
/// profiles: 24 bytes, 20-bit signed points, filled up to whole words, one word.
class ProfilerTwin : public ProfileSensor {
 public:
  /// @param x0_mm part position of the first point
  ProfilerTwin(const ProfilerParams& params, double x0_mm, double dx_mm);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { request_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  /// 1: a gauge block of 0.5 mm lies under the third of the line of smaller part x; 0: it is taken away.
  void trip(std::int64_t, std::int64_t code) override { gauge_ = code == 1; }
  void reboot(std::int64_t now_us) override;
  void io(Archive& a) override;

  void trigger(std::int64_t t_us, std::int32_t encoder_counts, std::span<const double> z_mm) override;
  std::uint32_t triggers() const override { return triggers_; }

 private:
  struct Shot {
    std::int64_t ready_us = kNever;
    std::uint32_t trigger = 0;
    std::int32_t encoder = 0;
    std::uint32_t points = 0;
    std::string packed;  ///< points of 20 bits, as they are sent
    void io(Archive& a) { a.all(ready_us, trigger, encoder, points, packed); }
  };
  static constexpr std::size_t kMemory = 4096;  ///< profiles
  void execute(std::span<const std::byte> request, std::int64_t now_us);
  std::string profiles(std::span<const std::byte> request, std::int64_t now_us);

  ProfilerParams params_;
  double x0_mm_, dx_mm_;
  std::string request_;
  std::uint8_t program_ = 0;
  std::uint32_t triggers_ = 0;  ///< since power on
  std::uint8_t gauge_ = 0;
  std::vector<std::int32_t> units_;  ///< of the profile that is packed
  Shot newest_, before_;             ///< the one before serves until the newest is ready
  std::deque<Shot> memory_;          ///< not forgotten yet, the newest last
};

/// Returns the spacing of points of a line that covers `grid` with 15 % to spare, in steps of 5 um [mm].
double profile_dx_mm(const GridSpec& grid, const ProfilerParams& params);
/// Returns the part position of the first point, the line being centred on the grid.
double profile_x0_mm(const GridSpec& grid, const ProfilerParams& params);

}  // namespace firn::plant
