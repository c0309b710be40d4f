// ScriptGas drives mass-flow controllers by a class in Python: set(atomizer_sccm, sheath_sccm) and read(),
// which returns sccm and kpa, two of each in the order atomizer, sheath. Order, limits and interlock 16 are
// held here. safe() ends the atomizer's gas and leaves the sheath's.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/gas/gas_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptGas final : public ScriptDriver<GasDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptGas(ScriptOptions script, GasOptions config);

  void set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kSet = kFirstTag, kRead };
  enum class Step : std::uint8_t { kNone, kFirst, kSecond };

  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t now_us, Effects& fx) override;
  bool work(std::int64_t now_us, Effects& fx) override;
  std::int64_t work_wake_us() const override { return ready() && !waits() ? next_read_us_ : 0; }
  void program_lost(Effects&) override;
  Result broken_off(Outcome outcome, std::int32_t code, std::string text) override;
  void begin_step(Step step, std::int64_t now_us);
  void judge(std::int64_t now_us, Effects& fx);
  void settle(std::int64_t now_us, Effects& fx);
  void stop_for(GasFault what, int n, const std::string& text, Figure figure, std::int64_t now_us,
                Effects& fx);

  std::array<double, 2> wanted_sccm_{};
  std::array<bool, 2> was_there_{};
  std::array<std::int64_t, 2> gone_since_us_{};
  int first_ = kSheath;  ///< the flow that changes first
  Step step_ = Step::kNone;
  bool to_send_ = false, read_since_ = false;
  std::int64_t next_read_us_ = 0, settle_until_us_ = 0;
  Figure figure_ = {};  ///< of the command's failure
};

}  // namespace firn::drivers
