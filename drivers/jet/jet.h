// Jet controls a MicroFab JetDrive III. Armed, it fires on every pulse of its trigger input (the stage's
// pulse output); disarmed, its trigger source is internal and nothing fires. It has no droplet counter:
// counted = -1, the stage's pulse counter is the evidence, as long as the jet was armed during all of the
// pass: where POLL tells the source it is asked at both ends, and a jet whose firmware had to be started anew
// has been without power.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/jet/jet_config.h"
#include "drivers/jet/jetdrive.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct JetOptions : JetConfig {
  int drops_per_trigger = 1;
  bool strobe = true;
  double poll_idle_s = 2.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

class Jet final : public Driver {
 public:
  /// @throws std::invalid_argument naming the field and its limit.
  explicit Jet(JetOptions config);

  /// Trigger source external, one drop per trigger; Result{kReady} when armed.
  void arm(std::int64_t expected, std::int64_t now_us, Effects& fx);
  /// Trigger source internal; Result{kDone} with counted = -1. Result{kUnknown} if the jet was not armed all
  /// the time since arm(): its droplets are in doubt.
  void disarm(std::int64_t now_us, Effects& fx);
  /// Droplets at the jet's own rate until disarm() or a stop, at most dialect.most_continuous_s:
  /// Result{kReady} when they come.
  void jet(std::int64_t now_us, Effects& fx);
  /// Refused unless the jet is safe: a waveform changed while jetting can break the instrument (I11).
  void set_waveform(const jetdrive::Waveform& waveform, std::int64_t now_us, Effects& fx);

  bool busy() const override { return op_ != Op::kNone; }

 private:
  enum class Op : std::uint8_t { kNone, kArm, kDisarm, kWaveform, kJet };
  enum class Phase : std::uint8_t {
    kDown,
    kAsking,  // whether its firmware runs since the last setup
    kHandshake,
    kBooting,
    kSetup,
    kReady,
    kArming,
    kArmed,
    kDisarming,
    kStopping,
    kWaveform,
    kStartingJet,
    kJetting
  };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  void begin_waveform(const jetdrive::Waveform& waveform, Effects& fx);
  void begin_disarm(Op op, std::int64_t now_us, Effects& fx);
  void end_jetting(std::int64_t now_us, Effects& fx);
  void start_firmware();
  void firmware_runs(bool external);
  void push_setup(bool reset);
  void permit_reset() override { reset_wanted_ = true; }
  void poll();
  bool tells_source() const { return version_ >= config_.dialect.poll_tells_source_from; }
  void take_source(bool external, std::int64_t now_us, Effects& fx);
  void disarmed(Effects& fx);
  void end_quietly(std::int64_t now_us, Effects& fx);
  void refuse(std::int32_t code, std::string text, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  JetOptions config_;
  jetdrive::Waveform waveform_;
  jetdrive::JetDriveDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  std::int64_t expected_ = 0;
  int version_ = 0;
  int asks_left_ = 0;             ///< connections that begin with POLL before the firmware is started anew
  bool reset_wanted_ = false;     ///< by a person: with a start of the firmware
  bool settled_ = false;          ///< it was still armed then, and from there on is only made safe
  bool source_external_ = false;  ///< SOURCE 1 is acknowledged, SOURCE 0 not yet: POLL must say so
  bool may_fire_ = false;         ///< from SOURCE 1 until SOURCE 0 is confirmed
  std::string not_armed_;         ///< why the jet may have been disarmed since arm(); empty: it was armed
  bool jetting_ = false;          ///< from CONTMODE 1 until CONTMODE 0 is confirmed
  std::int64_t jet_until_us_ = 0;
  std::int64_t boot_until_us_ = 0;
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
};

}  // namespace firn::drivers
