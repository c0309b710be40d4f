// Did the lab run every path as it was planned, each at most once, and nothing after a stop? The audit of a
// path printer, beside that of droplets (audit.h).
#pragma once

#include <vector>

#include "replay/audit.h"
#include "replay/run_messages.h"

namespace firn::replay {

/// A pulse list as a valve truly fired it. Which path it belongs to is told by the command that armed the
/// valve: the instrument's own numbers are its driver's.
struct TrueFiring {
  std::int64_t trigger_us = 0, last_us = 0;  ///< last pulse; 0 = none
  std::int64_t listed = 0, fired = 0;
  int valve = 0;  ///< 1 valve_a, 2 valve_b
};

/// Passes are paths, droplets are pulses; Unknown.pass is the path.
/// @param world nullptr where there is no record of the truth
AuditVerdict audit_paths(const RunMessages& messages, const std::vector<TrueFiring>* world,
                         const AuditOptions& options);

}  // namespace firn::replay
