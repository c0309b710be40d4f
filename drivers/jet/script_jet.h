// ScriptJet drives a jet by a class in Python: arm(expected), one droplet a pulse of the trigger input from
// then on, and disarm(), which returns the droplets that were fired, or None where the jet does not count.
// With armed() the class tells whether the jet is armed still; it is asked once a second.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/jet/jet_config.h"
#include "drivers/jet/jet_interface.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptJet final : public ScriptDriver<JetInterface> {
 public:
  explicit ScriptJet(ScriptOptions script);

  void arm(std::int64_t expected, std::int64_t now_us, Effects& fx) override;
  void arm_small(std::int64_t expected, std::int64_t now_us, Effects& fx) override;  ///< refused
  void disarm(std::int64_t now_us, Effects& fx) override;
  void jet(std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kArm = kFirstTag, kDisarm, kArmed };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t now_us, Effects& fx) override;
  bool work(std::int64_t now_us, Effects& fx) override;
  std::int64_t work_wake_us() const override;
  void program_lost(Effects&) override;
  Result ended(Outcome outcome, std::int64_t counted, std::int32_t code, std::string text) const;
  Result broken_off(Outcome outcome, std::int32_t code, std::string text) override;

  std::int64_t expected_ = 0;
  bool armed_ = false;
  std::string not_armed_;            ///< why it may have been disarmed since arm(); empty: it was armed
  std::int64_t armed_until_us_ = 0;  ///< when a stop disarmed it; 0: none did since arm()
  std::int64_t ask_us_ = 0;
};

}  // namespace firn::drivers
