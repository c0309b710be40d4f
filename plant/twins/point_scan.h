// PointScanTwin simulates a Keyence LK-G over the part of a stage lab, with the stage's pulses at its timing
// input: a value by itself at each pulse, and one on request (docs/devices/point_scan.md).
#pragma once

#include <string>

#include "plant/config/world_config.h"
#include "plant/twins/profile_sensor.h"

namespace firn::plant {

class PointScanTwin final : public ProfileSensor {
 public:
  PointScanTwin(const ProfilerParams& params, Look look);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void disconnected(std::int64_t) override { line_.clear(); }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  void reboot(std::int64_t now_us) override;
  /// 0: mended. 1: the head is dark, no values. 2: its value sticks. 3: the timing input's cable is off.
  /// 4: it bounces, each pulse counts twice. 5: a gauge block of 0.5 mm lies under the spot.
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;

  void trigger(std::int64_t t_us, std::int32_t encoder_counts, std::span<const double> z_mm) override;
  std::uint32_t triggers() const override { return triggers_; }
  bool speaks_at_pulses() const override { return true; }

 private:
  std::string execute(std::string_view command, std::int64_t now_us);
  std::string value(double height_mm);

  ProfilerParams params_;
  Look look_;
  std::string line_, last_;
  std::int32_t program_ = 0;
  bool communication_ = false;
  std::int64_t busy_until_us_ = 0, fault_ = 0;
  std::uint32_t triggers_ = 0;
};

}  // namespace firn::plant
