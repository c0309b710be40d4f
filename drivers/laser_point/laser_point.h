// LaserPoint controls the point laser Keyence LK-G3001P: settings per material, storage that starts with the
// robot's signal, read-out of the storage. The laser moves and fires nothing; its lines carry no checksum, so
// the link drains and probes after any doubt.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/laser_point/laser_point_driver.h"
#include "drivers/laser_point/lkg.h"

namespace firn::drivers {

class LaserPoint final : public LaserPointDriver {
 public:
  /// @throws std::invalid_argument naming the field: a sampling time or averaging that the instrument has
  /// not.
  explicit LaserPoint(LaserPointOptions config);

  /// A period must be a cycle of the sampling time.
  void arm(int material, int samples, double period_s, std::int64_t now_us, Effects& fx) override;
  void collect(std::int64_t now_us, Effects& fx) override;
  void reading(std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_ != Op::kNone; }
  std::int64_t timing_values() const { return timing_values_; }  ///< `TG` lines, which came by themselves

 private:
  enum class Op : std::uint8_t { kNone, kArm, kCollect, kReading };
  enum class Phase : std::uint8_t {
    kDown,
    kIdentifying,
    kReady,
    kSetting,
    kArming,
    kArmed,
    kCollecting,
    kReading
  };
  enum Tag : std::uint16_t { kPlain, kMode, kProgram, kStored, kDump, kValue };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void unsolicited(std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return false; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  bool accept(bool armed_too, Effects& fx);
  void refuse(std::int32_t code, std::string text, Effects& fx);
  void finish(Outcome outcome, std::int64_t counted, std::int32_t code, std::string text, Effects& fx);
  void refused(const Request& request, int error, std::int64_t now_us, Effects& fx);
  void give_up(const Request& request, const std::string& why, std::int64_t now_us, Effects& fx);
  void push(std::string_view command, Repeat repeat, Tag tag = kPlain, std::int64_t reply_us = 0);
  std::size_t value_chars() const { return std::size_t(config_.dialect.value_bytes) - 1; }
  void push_mode(const std::string& command);
  void push_selected(std::int32_t wanted);
  void push_settings();
  void ask_dump();

  LaserPointOptions config_;
  lkg::LkgDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  int sampling_code_ = 0;

  // The command in progress, or the storage that is armed.
  int material_ = 0;
  int expected_ = 0;
  int cycle_ = 0;
  double period_s_ = 0.0;
  bool storing_ = false;  // AS was sent since the last collect
  int stored_ = 0;        // of AN
  int dumps_ = 0;
  std::vector<float> mm_;
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;

  struct InForce {
    int material = 0;
    int cycle = 0;
    bool operator==(const InForce&) const = default;
  };
  std::optional<InForce> in_force_;  // nothing = unknown
  bool measuring_ = true;            // not in communication mode, as far as is known
  std::int64_t timing_values_ = 0;
};

}  // namespace firn::drivers
