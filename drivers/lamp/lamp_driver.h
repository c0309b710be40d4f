// LampDriver is the interface of all kinds of UV lamps: the orders of a print, whatever the maker's protocol.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "drivers/lamp/lamp_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct LampOptions : LampConfig {
  bool instrument_timer = true;  ///< try STM, GTM, RUN first
  double connect_every_s = 1.0;  ///< CONN is repeated until READY
  double poll_idle_s = 5.0;
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

class LampDriver : public Driver {
 public:
  using Options = LampOptions;

  /// The lamp shines on the part for exposure_s. Refused outside 0 < exposure_s <= max_on_s and 1 <=
  /// iris_percent <= 100.
  virtual void expose(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx) = 0;
  /// Interlock 9: while `why` is not empty no exposure begins, and one that has begun ends at once.
  virtual void bar(std::string_view why, std::int64_t now_us, Effects& fx) = 0;
  /// Dark, and its panel is free again. For the end of a run.
  virtual void release(std::int64_t now_us, Effects& fx) = 0;

 protected:
  explicit LampDriver(const Dialect& dialect) : Driver(dialect) {}

  static constexpr int kKeepIris = -1;
  /// Returns why no lamp takes this exposure; empty: it does.
  static std::string exposure_refusal(double exposure_s, int iris_percent, const LampConfig& config) {
    char why[120] = "";
    if (!(exposure_s > 0.0 && exposure_s <= config.max_on_s))
      std::snprintf(why, sizeof why, "an exposure of %g s is outside (0, %g] s", exposure_s, config.max_on_s);
    else if (iris_percent != kKeepIris && (iris_percent < 1 || iris_percent > 100))
      std::snprintf(why, sizeof why, "an iris of %d %% is outside [1, 100] %%", iris_percent);
    return why;
  }
};

}  // namespace firn::drivers
