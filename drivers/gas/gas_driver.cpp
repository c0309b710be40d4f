#include "drivers/gas/gas_driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/options/enumerators.h"

namespace firn::drivers {
namespace {

constexpr double kMinMeasured = 0.002;  // of the full scale: below it a flow is none

}  // namespace

const char* name(GasFault fault) {
  static constexpr const char* kFaults[] = {"well", "the flow is lost", "another set point than commanded",
                                            "the pressure behind the nozzle is too high",
                                            "its values are beyond its range, or its valve is held"};
  static_assert(std::size(kFaults) == kTableSize<GasFault>);
  return kFaults[int(fault)];
}

GasDriver::GasDriver(const Dialect& dialect, GasOptions config)
    : Driver(dialect), config_(std::move(config)) {
  check_options("gas", kGasConfig, config_);
}

const char* GasDriver::name_of(int n) { return n == kAtomizer ? "atomizer" : "sheath"; }

std::string GasDriver::refusal_of(double atomizer_sccm, double sheath_sccm) const {
  const std::array<double, 2> sccm{atomizer_sccm, sheath_sccm};
  const std::array<double, 2> most{config_.atomizer_max_sccm, config_.sheath_max_sccm};
  std::string why;
  char text[160];
  for (std::size_t n = 0; n < 2; ++n)
    if (!(sccm[n] >= 0.0 && sccm[n] <= most[n])) {
      std::snprintf(text, sizeof text, "%s: a set point of %g sccm is outside [0, %g] sccm", name_of(int(n)),
                    sccm[n], most[n]);
      why = text;
    }
  if (why.empty() && atomizer_sccm > 0.0 && !(sheath_sccm > 0.0)) {
    std::snprintf(text, sizeof text, "%g sccm of atomizer gas without a sheath's: the nozzle would clog",
                  atomizer_sccm);
    why = text;
  }
  return why;
}

bool GasDriver::there(int n) const {
  const auto k = std::size_t(n);
  return std::abs(flows_.sccm[k] - commanded_sccm_[k]) <= tolerance_sccm(n);
}

double GasDriver::tolerance_sccm(int n) const {
  const double full = n == kAtomizer ? config_.atomizer_max_sccm : config_.sheath_max_sccm;
  return std::max(config_.tolerance * commanded_sccm_[std::size_t(n)], kMinMeasured * full);
}

}  // namespace firn::drivers
