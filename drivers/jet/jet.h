// Jet controls a MicroFab JetDrive III. Armed, it fires on every pulse of its trigger input (the stage's
// pulse output); disarmed, its trigger source is internal and nothing fires. It has no droplet counter:
// counted = -1, the stage's pulse counter is the evidence, as long as the jet was armed during all of the
// pass: where POLL tells the source it is asked at both ends, and a jet whose firmware had to be started anew
// has been without power.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/jet/jet_driver.h"
#include "drivers/jet/jetdrive.h"

namespace firn::drivers {

extern const JetTraits kJetDriveTraits;

class Jet final : public JetDriver {
 public:
  /// @throws std::invalid_argument naming the field and its limit.
  explicit Jet(JetOptions config);

  void jet(std::int64_t now_us, Effects& fx) override;
  /// Refused unless the jet is safe: a waveform changed while jetting can break the instrument (I11).
  void set_waveform(const jetdrive::Waveform& waveform, std::int64_t now_us, Effects& fx);

 private:
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
  void cease(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping; }
  bool ready() const override { return phase_ == Phase::kReady; }
  bool at_rest() const override { return ready() || phase_ == Phase::kArmed || phase_ == Phase::kJetting; }
  void start_arming(bool small) override;                           ///< trigger source external
  void start_disarming(std::int64_t now_us, Effects& fx) override;  ///< trigger source internal
  // jet_service.cpp
  void fire(int droplets, Service& s) override;
  void jet_for(double seconds, Service& s) override;
  void strobe(int divider, int delay_us, Service& s) override;
  void pulses(const JetPulses& pulses, Service s, Effects& fx) override;
  bool obeyed(const Request& request, std::span<const std::byte> frame) const override;

  void take_size(bool small);
  void send_waveform();
  void begin_waveform(const jetdrive::Waveform& waveform, Effects& fx);
  void end_jetting(std::int64_t now_us, Effects& fx);
  void start_firmware();
  void firmware_runs(bool external, std::int64_t now_us);
  void push_setup(bool reset);
  void permit_reset() override { reset_wanted_ = true; }
  void poll();
  bool tells_source() const { return version_ >= config_.dialect.poll_tells_source_from; }
  void take_source(bool external, std::int64_t now_us, Effects& fx);
  void end_quietly(std::int64_t now_us, Effects& fx);

  jetdrive::Waveform waveform_;  ///< of droplets of the first size
  bool small_ = false;           ///< the last waveform that was sent is that of small droplets
  bool waveform_held_ = false;   ///< the jet has acknowledged it
  jetdrive::JetDriveDialect dialect_;
  Phase phase_ = Phase::kDown;
  int version_ = 0;
  int asks_left_ = 0;             ///< connections that begin with POLL before the firmware is started anew
  bool reset_wanted_ = false;     ///< by a person: with a start of the firmware
  bool settled_ = false;          ///< it was still armed then, and from there on is only made safe
  bool source_external_ = false;  ///< SOURCE 1 is acknowledged, SOURCE 0 not yet: POLL must say so
  bool jetting_ = false;          ///< from CONTMODE 1 until CONTMODE 0 is confirmed
  std::int64_t jet_until_us_ = 0;
  std::int64_t boot_until_us_ = 0;
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
};

}  // namespace firn::drivers
