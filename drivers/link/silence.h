// SilenceWatch finds an instrument that has fallen silent between commands, when nobody waits for its answer.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "drivers/link/dialect.h"

namespace firn::drivers {

class SilenceWatch {
 public:
  /// @param period_us between the questions of a driver at rest @param dialect whose time-outs three
  /// questions take
  SilenceWatch(std::int64_t period_us, const Dialect& dialect) : period_us_(period_us), dialect_(dialect) {}

  /// A good reply has come, or nothing is asked now: the time begins anew.
  void heard(std::int64_t now_us) {
    heard_us_ = now_us;
    told_ = false;
  }
  /// Nobody depends on the instrument any more, or not yet.
  void end() { heard_us_ = 0; }

  /// Returns true once for each silence that lasts longer than a period and three time-outs.
  bool is_over(std::int64_t now_us) {
    if (heard_us_ == 0 || told_ || now_us < heard_us_ + longest_us()) return false;
    return told_ = true;
  }
  /// Time at which is_over() must be asked next; 0 = never.
  std::int64_t wake_us() const { return heard_us_ == 0 || told_ ? 0 : heard_us_ + longest_us(); }
  std::string words() const {
    char text[40];
    std::snprintf(text, sizeof text, "no answer for %.1f s", double(longest_us()) * 1e-6);
    return text;
  }

 private:
  std::int64_t longest_us() const {
    const Timeouts& t = dialect_.timeouts;
    return period_us_ + 3 * (t.write_us + t.reply_us + t.quiet_us);
  }

  std::int64_t period_us_;
  const Dialect& dialect_;
  std::int64_t heard_us_ = 0;  // 0: not watched
  bool told_ = false;
};

}  // namespace firn::drivers
