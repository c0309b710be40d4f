// Microdrop controls a Microdrop MD-E dispenser [S: one lab's driver, docs/devices/jet.md]. Its public
// commands name no external trigger: the stage's pulses fire it only where jet.trigger_on holds the text of
// the unit's manual [P]; without it arming is refused by name.
#pragma once

#include "drivers/jet/jet.h"

namespace firn::drivers {

/// 19200 8N1: "Command(head,...)\r", answered by one line; a number has one character before it.
class MicrodropDialect : public Dialect {
 public:
  Frame frame(std::span<const std::byte> buffer, const Request* awaited) const override;
  Request probe() const override;
};

namespace microdrop {

enum Format : std::uint8_t { kAny, kNumber };
inline constexpr std::int32_t kUnchecked = -1;

/// The number of an answer; -1 = none.
std::int32_t number_of(std::span<const std::byte> line);
Request command(const std::string& text, Repeat repeat = Repeat::kSetup);
Request command(const char* text, double value);  ///< "SetFrequency(1," and a value, rounded
Request question(const char* text, double expected = kUnchecked);

}  // namespace microdrop

class Microdrop final : public Driver {
 public:
  /// dwell_v and dwell_us are the pulse. @throws std::invalid_argument naming the setting and its range
  explicit Microdrop(JetOptions config);
  /// As Jet's. The unit counts no droplets: counted = -1.
  void arm(std::int64_t expected, std::int64_t now_us, Effects& fx);
  void disarm(std::int64_t now_us, Effects& fx);
  /// Refused: the unit has no jetting that a stop ends.
  void jet(std::int64_t now_us, Effects& fx);
  bool busy() const override { return op_ != Op::kNone; }

 private:
  enum class Op : std::uint8_t { kNone, kArm, kDisarm };
  enum class Phase : std::uint8_t { kDown, kSetup, kReady, kArming, kArmed, kStopping };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request&, std::span<const std::byte> frame, std::int64_t now_us, Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;
  void read_back();
  void give_up(std::int32_t code, const std::string& why, std::int64_t now_us, Effects& fx);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  JetOptions config_;
  MicrodropDialect dialect_;
  Phase phase_ = Phase::kDown;
  Op op_ = Op::kNone;
  std::int64_t expected_ = 0;
  bool may_fire_ = false;  ///< from trigger_on until SetActive(1,0) is answered
  std::string doubt_;      ///< why it may not have been armed all the time
};

}  // namespace firn::drivers
