// Gas controls two Alicat mass-flow controllers on one line.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/gas/alicat.h"
#include "drivers/gas/gas_driver.h"

namespace firn::drivers {

class Gas final : public GasDriver {
 public:
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Gas(GasOptions config);

  void set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx) override;

  bool busy() const override { return op_; }

 private:
  enum class Phase : std::uint8_t {
    kDown,
    kIdentifying,
    kReady,
    kFirst,     ///< the flow that goes first is on its way
    kSecond,    ///< and the other one
    kStopping,  ///< the atomizer's gas is being ended
    kRefused,   ///< no instrument of this lab: until the next connection
  };
  enum Tag : std::uint16_t { kVersionTag, kReadTag, kSetTag };

  void connected(std::int64_t now_us, Effects& fx) override;
  void reply(const Request& request, std::span<const std::byte> frame, std::int64_t now_us,
             Effects& fx) override;
  void failed(const Request& request, std::int64_t now_us, Effects& fx) override;
  void lost(std::int64_t now_us, Effects& fx) override;
  void stop(std::int64_t now_us, Effects& fx) override;
  bool idle(std::int64_t now_us, Effects& fx) override;
  std::int64_t device_wake_us() const override;
  bool stopping() const override { return phase_ == Phase::kStopping; }
  void service(std::string_view verb, std::span<const double> values, std::int64_t now_us,
               Effects& fx) override;

  alicat::Unit unit(int n) const {
    return {n == kAtomizer ? config_.atomizer_unit[0] : config_.sheath_unit[0], dollars_[std::size_t(n)]};
  }
  int index_of(const Request& request) const {
    return request.argument == config_.sheath_unit[0] ? kSheath : kAtomizer;
  }
  void send_set_point(int n);
  void take(int n, const alicat::Reading& reading, std::int64_t now_us, Effects& fx);
  void judge(std::int64_t now_us, Effects& fx);
  /// Returns the share of its set point that flows, and the end of the tolerance that it is beyond.
  Figure settled_share(int n) const;
  void refused(const Request& request, const std::string& why, std::int64_t now_us, Effects& fx);
  void end_atomizer(std::int64_t now_us, Effects& fx);
  void begin_step(Phase phase, int n, std::int64_t now_us);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx, const Figure& figure = {});

  alicat::AlicatDialect dialect_;
  Phase phase_ = Phase::kDown;
  bool op_ = false;
  std::array<bool, 2> dollars_{};
  std::array<std::string, 2> version_;
  std::array<double, 2> wanted_sccm_{};     ///< of the command in progress, or the last one
  std::array<double, 2> tolerated_sccm_{};  ///< by which a set point as shown may be off
  std::array<bool, 2> was_there_{};
  std::array<std::int64_t, 2> gone_since_us_{};
  int first_ = kSheath;             ///< the flow that changes first
  int round_ = 0;                   ///< readings since the set point was sent
  std::array<int, 2> other_gas_{};  ///< times in succession that another gas was named
  std::int64_t next_read_us_ = 0, settle_until_us_ = 0;
};

}  // namespace firn::drivers
