// Gas controls the aerosol lab's two mass-flow controllers on one line: the atomizer's gas, which carries the
// ink, and the sheath's, which keeps it off the nozzle. The sheath flows before the atomizer and after it; a
// stop ends the atomizer's gas and leaves the sheath's. Interlock 16: no ink without a sheath, no pressure
// behind the nozzle beyond gas.most_pressure_kpa.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "drivers/gas/alicat.h"
#include "drivers/gas/gas_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct GasOptions : GasConfig {
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

inline constexpr std::int32_t kGas = 16;  ///< interlock of docs/safety.md

/// Of GasFlows::fault and gas_flow_t.
enum class GasFault : std::int8_t { kNone, kFlowLost, kSetPoint, kPressure, kCode };
const char* name(GasFault fault);

inline constexpr int kAtomizer = 0, kSheath = 1;

/// One round of readings, in the order atomizer, sheath.
struct GasFlows {
  std::array<double, 2> sccm{}, set_sccm{}, kpa{}, celsius{};
  std::array<GasFault, 2> fault{};
  bool steady = false;  ///< both flows are at the set points that were commanded
};

class Gas final : public Driver {
 public:
  using Measurements = std::tuple<GasFlows>;
  /// @throws std::invalid_argument naming the setting, its value and its range
  explicit Gas(GasOptions config);

  /// Done when both flows are there; kFailed after settle_s. Refused: beyond the lab's limits, and an
  /// atomizer's flow without a sheath's.
  void set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx);

  bool busy() const override { return op_; }
  const GasFlows& flows() const { return flows_; }

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
  bool there(int n) const;
  double tolerance_sccm(int n) const;  ///< of a flow that is there
  /// Returns the share of its set point that flows, and the end of the tolerance that it is beyond.
  Figure settled_share(int n) const;
  void refused(const Request& request, const std::string& why, std::int64_t now_us, Effects& fx);
  void end_atomizer(std::int64_t now_us, Effects& fx);
  void begin_step(Phase phase, int n, std::int64_t now_us);
  void finish(Outcome outcome, std::int32_t code, std::string text, Effects& fx, const Figure& figure = {});

  GasOptions config_;
  alicat::AlicatDialect dialect_;
  Phase phase_ = Phase::kDown;
  bool op_ = false;
  std::array<bool, 2> dollars_{};
  std::array<std::string, 2> version_;
  std::array<double, 2> wanted_sccm_{};     ///< of the command in progress, or the last one
  std::array<double, 2> commanded_sccm_{};  ///< sent to the instrument
  std::array<double, 2> tolerated_sccm_{};  ///< by which a set point as shown may be off
  std::array<bool, 2> was_there_{};
  std::array<std::int64_t, 2> gone_since_us_{};
  int first_ = kSheath;             ///< the flow that changes first
  int round_ = 0;                   ///< readings since the set point was sent
  std::array<int, 2> other_gas_{};  ///< times in succession that another gas was named
  GasFlows flows_;
  std::int64_t next_read_us_ = 0, settle_until_us_ = 0;
};

}  // namespace firn::drivers
