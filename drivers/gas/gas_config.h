// GasConfig holds the settings of the aerosol lab's mass-flow controllers, with range and meaning of each.
#pragma once

#include <string>

#include "core/options/on_off.h"
#include "core/options/option.h"

namespace firn::drivers {

/// Texts and numbers that differ between installations: a table, not code. `@` in a text is the unit.
struct GasDialect {
  std::string version = "@VE", manufacturer = "@??M*", set_point = "@S";
  double sccm_per_unit = 1.0;
  double kpa_per_unit = 6.894757;
  int decimals = 3;
};
inline constexpr OptionTable kGasDialect{
    Option{"version", &GasDialect::version, "", Range{}, "question for the firmware; @ is the unit [C]"},
    Option{"manufacturer", &GasDialect::manufacturer, "", Range{},
           "question for model and serial number, answered by several lines [C]"},
    Option{"set_point", &GasDialect::set_point, "", Range{}, "command before the number of a set point [C]"},
    Option{"sccm_per_unit", &GasDialect::sccm_per_unit, "", above(0, 1e6),
           "of the flow as it is displayed: 1 = SCCM, 1000 = SLPM [P]"},
    Option{"kpa_per_unit", &GasDialect::kpa_per_unit, "", above(0, 1e4),
           "of the pressure as it is displayed: 6.894757 = PSIA [P]"},
    Option{"decimals", &GasDialect::decimals, "", within(0, 6), "of a set point as it is sent [S]"},
};

struct GasConfig {
  OnOff use = OnOff::kOff;
  std::string atomizer_unit = "A", sheath_unit = "B", gas = "N2";
  double atomizer_sccm = 20.0, sheath_sccm = 40.0;  ///< while it prints
  double atomizer_max_sccm = 100.0, sheath_max_sccm = 500.0;
  double tolerance = 0.05;
  double settle_s = 10.0;
  double steady_s = 8.0;
  double lost_s = 1.0;
  double lost_share = 0.5;
  double most_pressure_kpa = 120.0;
  double poll_s = 0.25;
  GasDialect dialect = {};  ///< [devices.gas.dialect]
};
inline constexpr OptionTable kGasConfig{
    Option{"use", &GasConfig::use, "", Range{}, "on: the lab has mass-flow controllers"},
    Option{"atomizer_unit", &GasConfig::atomizer_unit, "", Range{}, "unit id of the atomizer gas, A to Z"},
    Option{"sheath_unit", &GasConfig::sheath_unit, "", Range{},
           "unit id of the sheath gas, on the same line"},
    Option{"gas", &GasConfig::gas, "", Range{}, "that both controllers must be set to"},
    Option{"atomizer_sccm", &GasConfig::atomizer_sccm, "sccm", within(0, 1e5),
           "atomizer gas while it prints"},
    Option{"sheath_sccm", &GasConfig::sheath_sccm, "sccm", within(0, 1e5), "sheath gas while it prints"},
    Option{"atomizer_max_sccm", &GasConfig::atomizer_max_sccm, "sccm", above(0, 1e5),
           "set points above it are refused (I16)"},
    Option{"sheath_max_sccm", &GasConfig::sheath_max_sccm, "sccm", above(0, 1e5), "the same"},
    Option{"tolerance", &GasConfig::tolerance, "", above(0, 1), "share of a set point: the flow is there"},
    Option{"settle_s", &GasConfig::settle_s, "s", above(0, 600), "longest time for it"},
    Option{"steady_s", &GasConfig::steady_s, "s", within(0, 3600),
           "from flows that are there to ink that flows evenly: no line begins before"},
    Option{"lost_s", &GasConfig::lost_s, "s", above(0, 60),
           "a flow that was there and is lost for so long stops the print (I16)"},
    Option{"lost_share", &GasConfig::lost_share, "", above(0, 1), "a flow below this share of its set point"},
    Option{"most_pressure_kpa", &GasConfig::most_pressure_kpa, "kPa", above(0, 1e4),
           "absolute, behind the nozzle: above it the nozzle clogs (I16)"},
    Option{"poll_s", &GasConfig::poll_s, "s", above(0, 10), "between readings"},
};

}  // namespace firn::drivers
