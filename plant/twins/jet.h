// JetTwin simulates the jet driver MicroFab JetDrive III: binary frames at 9600 baud, fired by its external
// trigger input.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plant/config/world_config.h"
#include "plant/twins/pulse_response.h"
#include "plant/twins/twin.h"

namespace firn::plant {

/// Frame: 53 len cmd data… sum, len = bytes behind 'S' without sum, sum = (len + … + last data) mod 256,
/// big-endian.
class JetTwin : public Twin {
 public:
  /// @param port kJet or kJetB: the lab has one per ink
  JetTwin(Port port, const JetParams& params, Wires& wires);
  void take(std::span<const std::byte> bytes, std::int64_t now_us) override;
  void connected(std::int64_t now_us) override { deaf_until_us_ = now_us + params_.settle_us; }
  void disconnected(std::int64_t) override {  // the jet stays as it is
    frame_.clear();
    greeting_ = 0;
  }
  std::int64_t next_device_us() const override { return kNever; }
  void device_event(std::int64_t) override {}
  void reboot(std::int64_t now_us) override;
  /// 1: its panel switches the source to internal, 2: it acknowledges SOURCE 1 and stays internal, 3: the
  /// nozzle is dead
  void trip(std::int64_t now_us, std::int64_t code) override;
  void io(Archive& a) override;

  /// A pulse on the trigger input. On kFired, `droplets` is the number of DROPS.
  ShotOutcome trigger(std::int64_t t_us, int& droplets);
  /// Droplets follow each other until CONTMODE 0; `starts` counts how often they began.
  bool jetting() const { return state_.jetting; }
  std::uint32_t starts() const { return state_.starts; }
  bool nozzle_dead() const { return trip_ == 3; }
  const JetPulse& pulse() const { return pulse_; }  ///< the one that was loaded

 protected:  // of other jets' twins too: the same head behind other words
  struct State {
    bool external = false;    ///< SOURCE 1
    bool waveform = false;    ///< a PULSE was loaded
    bool continuous = false;  ///< CONTMODE
    bool jetting = false;     ///< SOFTTRIGGER came since
    std::uint32_t starts = 0;
    std::uint8_t strobe_divider = 1, strobe = 0;
    std::uint16_t drops = 1, rate_hz = 1000, low_rate_hz = 0, strobe_delay_us = 0;
    std::uint32_t fired = 0;  ///< triggers obeyed since SOURCE was last set to external
    std::int64_t busy_until_us = 0;
    std::int64_t last_fired_us = -1'000'000'000;
    void io(Archive& a) {
      a.all(external, waveform, continuous, jetting, starts, strobe_divider, strobe, drops, rate_hz);
      a.all(low_rate_hz, strobe_delay_us, fired, busy_until_us, last_fired_us);
    }
  };
  void set_source(bool external, std::int64_t now_us);

  JetParams params_;
  Wires& wires_;
  State state_;
  JetPulse pulse_{};
  std::int64_t trip_ = 0, deaf_until_us_ = 0;

 private:
  void byte(std::uint8_t b, std::int64_t now_us);
  void execute(std::int64_t now_us);
  void answer(bool ack, std::uint8_t command, std::uint8_t status, std::int64_t now_us);
  void dump(std::int64_t now_us);
  bool beyond_head(const std::uint8_t* pulse) const;
  bool remote_ = false;              ///< X2000 was received
  std::uint32_t greeting_ = 0;       ///< characters of X2000 seen
  std::vector<std::uint8_t> frame_;  ///< from 'S' on
};

}  // namespace firn::plant
