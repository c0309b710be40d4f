// Ports of the instruments of a lab: which are real, and where.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/experiment.h"
#include "files/port_address.h"

namespace firn {

/// Port of an instrument that the lab can do without, and does.
inline constexpr std::string_view kNoInstrument = "none";

/// Returns the defaults of an instrument's port; none for another node.
std::optional<PortDefaults> port_defaults(std::string_view node);

/// Returns the `[devices.NODE] port` text of an instrument. @throws std::invalid_argument: no instrument
const std::string& port_text(const DevicesConfig& devices, std::string_view node);

/// Returns the addresses of all instruments of the lab that are not in the simulated world, by node: real
/// ones and cassettes.
/// @throws std::invalid_argument naming an address that is none
std::map<std::string, PortAddress> outside_ports(const Experiment& experiment);

/// Returns those of them that are real.
std::map<std::string, PortAddress> real_ports(const Experiment& experiment);

/// Returns the instruments of the lab that are in the simulated world, in the lab's order.
std::vector<std::string> simulated_ports(const Experiment& experiment);

/// Returns "REAL: stage (tcp:10.0.0.2:8000), jet (...); SIMULATED: lamp (cassette:FILE), heater", without a
/// part that is empty.
std::string ports_text(const Experiment& experiment);

}  // namespace firn
