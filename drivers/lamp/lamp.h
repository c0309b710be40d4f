// Lamp controls the UV lamp Excelitas OmniCure S2000. Timed exposures: by the instrument's own timer when it
// confirms the time, else by the driver's. Either way the shutter is told to close when the time is over, on
// a stop, at the end, and before anything else after a lost link; it is never left open longer than max_on_s
// (I9). The lamp's own status bits are the witness: that it burns and is warm before an exposure, that the
// shutter opened, that it closed.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/lamp/lamp_driver.h"
#include "drivers/lamp/omnicure.h"
#include "drivers/link/silence.h"

namespace firn::drivers {

class Lamp final : public LampDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Lamp(LampOptions config);

  void expose(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx) override {
    begin_exposure(exposure_s, iris_percent, now_us, fx);
    pump(now_us, fx);
  }
  void bar(std::string_view why, std::int64_t now_us, Effects& fx) override;
  /// Shutter closed, then DCON.
  void release(std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return exposing_; }
  bool may_be_open() const { return open_since_us_ != 0; }

  void resumed() override { silence_.end(); }

 private:
  enum class Phase : std::uint8_t {
    kDown,
    kConnecting,
    kWaiting,
    kClosing,
    kReady,
    kChecking,
    kPreparing,
    kOpening,
    kExposing,
    kReleased
  };
  enum Tag : std::uint16_t {
    kPlain,
    kConnect,
    kVersion,
    kSetTime,
    kGetTime,
    kOpen,
    kClose,
    kDisconnect,
    kStatus
  };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  void tick(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  std::int64_t work_wake_us() const;
  bool stopping() const override { return phase_ == Phase::kClosing; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  void begin_exposure(double exposure_s, int iris_percent, std::int64_t now_us, Effects& fx);
  void close_shutter(std::int64_t now_us, Effects& fx);
  void prepare(Effects& fx);
  // The lamp's status bits.
  void ask_status(std::int64_t now_us);
  void status(std::uint32_t bits, std::int64_t now_us, Effects& fx);
  void check_before(std::uint32_t bits, std::int64_t now_us, Effects& fx);
  void fail_exposure(std::string why, std::int64_t now_us, Effects& fx);
  bool ask_again(std::int64_t now_us);
  void expect_open(std::int64_t now_us);
  void push(std::string_view text, omnicure::Format format, Repeat repeat, Tag tag);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx);

  LampOptions config_;
  omnicure::OmnicureDialect dialect_;
  SilenceWatch silence_;
  Phase phase_ = Phase::kDown;
  bool exposing_ = false;  // an accepted exposure whose Result is to come
  std::int64_t exposure_us_ = 0;
  bool by_instrument_ = false;
  bool opened_ = false;  // RUN or OPN was sent for it
  std::int64_t tenths_ = 0;
  int iris_percent_ = 0;
  // Status questions: the next one, and the end of the wait for what is asked about.
  std::int64_t ask_at_us_ = 0;
  std::int64_t ask_until_us_ = 0;
  bool seen_open_ = false;          // by the status bits, in this exposure
  bool seen_closed_ = false;        // since the shutter was told to close
  bool told_on_ = false;            // TON was sent on this connection
  bool releasing_ = false;          // DCON follows once the shutter is closed
  std::int64_t open_since_us_ = 0;  // 0 = known to be closed
  std::int64_t close_at_us_ = 0;
  std::int64_t again_at_us_ = 0;  // next CONN
  bool overdue_told_ = false;
  std::string barred_;  ///< why nothing may be exposed now
  std::string ending_;
  std::int32_t ending_code_ = kNoCode;
};

}  // namespace firn::drivers
