// ScriptLamp drives a UV lamp by a class in Python: on(iris_percent), off(), and if the class has it lit(),
// which tells whether the lamp shines. The exposure is timed here, and interlock 9 is held here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/lamp/lamp_driver.h"
#include "drivers/script/script_driver.h"

namespace firn::drivers {

class ScriptLamp final : public ScriptDriver<LampDriver> {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  ScriptLamp(ScriptOptions script, LampOptions config);

  void expose(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx) override {
    begin_exposure(exposure_s, iris_percent, now_us, fx);
    pump(now_us, fx);
  }
  void bar(std::string_view why, std::int64_t now_us, Effects& fx) override;
  void release(std::int64_t now_us, Effects& fx) override;

 private:
  enum Tag : std::uint16_t { kOn = kFirstTag, kOff, kLit, kDark };

  void begin_exposure(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx);
  void returned(std::uint16_t tag, const Line& line, std::int64_t now_us, Effects& fx) override;
  void became_safe(std::int64_t now_us, Effects& fx) override;
  bool work(std::int64_t now_us, Effects& fx) override;
  void work_tick(std::int64_t now_us, Effects& fx) override;
  std::int64_t work_wake_us() const override { return waits() || ends_us_ == 0 ? overdue_us_ : ends_us_; }
  void program_lost(Effects&) override { ends_us_ = 0; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;
  void exposed(Effects& fx);
  void fail(const std::string& why, std::int64_t now_us, Effects& fx);

  LampOptions config_;
  std::int64_t exposure_us_ = 0;
  std::int64_t ends_us_ = 0;     // of the exposure that goes on; 0: none does
  std::int64_t overdue_us_ = 0;  // interlock 9: off() must have returned by then; 0: it need not
  std::string barred_;
};

}  // namespace firn::drivers
