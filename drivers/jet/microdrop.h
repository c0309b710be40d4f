// Microdrop controls a Microdrop MD-E dispenser [S: one lab's driver, docs/devices/jet.md]. Its public
// commands name no external trigger: the stage's pulses fire it only where jet.trigger_on holds the text of
// the unit's manual [P]; without it arming is refused by name.
#pragma once

#include "drivers/jet/jet_driver.h"
#include "drivers/link/line_dialect.h"

namespace firn::drivers {

extern const JetTraits kMicrodropTraits;

/// 19200 8N1: "Command(head,...)\r", answered by one line; a number has one character before it.
class MicrodropDialect : public LineDialect {
 public:
  MicrodropDialect() : LineDialect('\r', 100) {}
  char line_end() const override { return 0; }  ///< the character before a number may be any
  Request probe() const override;

 private:
  bool answers(std::string_view body, const Request& asked) const override;
};

class Microdrop final : public JetDriver {
 public:
  /// dwell_v and dwell_us are the pulse.
  explicit Microdrop(JetOptions config);

 private:
  enum class Phase : std::uint8_t { kDown, kSetup, kReady, kArming, kArmed, kStopping };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request&, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void cease(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  bool stopping() const override { return phase_ == Phase::kStopping; }
  bool ready() const override { return phase_ == Phase::kReady; }
  bool at_rest() const override { return ready() || phase_ == Phase::kArmed; }
  void start_arming(bool small) override;
  void fire(int droplets, Service& s) override;
  void jet_for(double seconds, Service& s) override;
  void strobe(int divider, int delay_us, Service& s) override;
  void pulses(const JetPulses& pulses, Service s, Effects& fx) override;
  bool obeyed(const Request& request, std::span<const std::byte> line) const override;
  std::vector<Request> pulse_set() const;
  std::vector<Request> held() const;

  MicrodropDialect dialect_;
  Phase phase_ = Phase::kDown;
};

}  // namespace firn::drivers
