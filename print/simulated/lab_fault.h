// Reads the faults that a person causes in a simulated instrument while a print runs: --fault "SECONDS PORT
// KIND [COUNT [DELAY_US]]".
#pragma once

#include <string>
#include <vector>

#include "plant/twins/fault.h"

namespace firn {

struct Experiment;

struct LabFault {
  double node_s = 0.0;  ///< of this incarnation's node time, as in the log
  plant::SimFault fault;
};

/// Reads faults: "120 valve_a trip 1": at 120 s of node time the water tank is empty. Kinds:
/// plant/twins/fault.h. Returned in order of time.
/// @throws UsageError: not of that form, an unknown kind, an instrument that the lab lacks
std::vector<LabFault> parse_lab_faults(const std::vector<std::string>& texts, const Experiment& experiment);

/// Returns the fault in the form of the world's control line.
std::string simfault_line(const plant::SimFault& fault);

}  // namespace firn
