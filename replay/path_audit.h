// Compares the paths that ran with the plan: the lab must run every path as planned, each at most once, and
// nothing after a stop. The audit of a path printer, beside the audit of droplets (audit.h).
#pragma once

#include <vector>

#include "replay/audit.h"
#include "runs/read/run_reader.h"

namespace firn::replay {

/// Holds a pulse list as a valve truly fired it. The command that armed the valve identifies the path of the
/// list: the instrument's own numbers belong to its driver.
struct TrueFiring {
  std::int64_t trigger_us = 0, last_us = 0;  ///< last pulse; 0: no pulse
  std::int64_t listed = 0, fired = 0;
  int valve = 0;  ///< 1 valve_a, 2 valve_b
};

/// Returns the verdict of the audit: passes are paths, droplets are pulses; Unknown.pass is the path.
/// @param world nullptr if there is no record of the truth
AuditVerdict audit_paths(const runs::RunReader& messages, const std::vector<TrueFiring>* world,
                         const AuditOptions& options);

}  // namespace firn::replay
