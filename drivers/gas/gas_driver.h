// GasDriver is the interface of all kinds of mass-flow controllers: the atomizer's gas, which carries the
// ink, and the sheath's, which keeps it off the nozzle. The sheath flows before the atomizer and after it; a
// stop ends the atomizer's gas and leaves the sheath's. Interlock 16: no ink without a sheath, no pressure
// behind the nozzle beyond gas.most_pressure_kpa.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <tuple>

#include "drivers/gas/gas_config.h"
#include "drivers/link/driver.h"

namespace firn::drivers {

struct GasOptions : GasConfig {
  double host_latency_s = 0.0;  ///< see Dialect::allow_host_latency
};

inline constexpr std::int32_t kGas = 16;  ///< interlock of docs/safety.md

/// Causes in GasFlows::fault and gas_flow_t.
enum class GasFault : std::int8_t { kNone, kFlowLost, kSetPoint, kPressure, kCode };
const char* name(GasFault fault);

inline constexpr int kAtomizer = 0, kSheath = 1;

/// One round of readings, in the order atomizer, sheath.
struct GasFlows {
  std::array<double, 2> sccm{}, set_sccm{}, kpa{}, celsius{};
  std::array<GasFault, 2> fault{};
  bool steady = false;  ///< both flows are at the set points that were commanded
};

class GasDriver : public Driver {
 public:
  using Options = GasOptions;
  using Measurements = std::tuple<GasFlows>;

  /// Done when both flows are there; kFailed after settle_s. Refused: beyond the lab's limits, and an
  /// atomizer's flow without a sheath's.
  virtual void set(double atomizer_sccm, double sheath_sccm, std::int64_t now_us, Effects& fx) = 0;
  const GasFlows& flows() const { return flows_; }

 protected:
  /// @throws std::invalid_argument naming the setting, its value and its range
  GasDriver(const Dialect& dialect, GasOptions config);

  static const char* name_of(int n);  ///< "atomizer", "sheath"
  /// Returns why these set points are not taken; empty: they are.
  std::string refusal_of(double atomizer_sccm, double sheath_sccm) const;
  /// By which a flow may be off that is there.
  double tolerance_sccm(int n) const;
  bool there(int n) const;

  GasOptions config_;
  std::array<double, 2> commanded_sccm_{};  ///< sent to the instrument
  GasFlows flows_;
};

}  // namespace firn::drivers
