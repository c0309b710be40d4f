// audit_run compares the nodes' records of a run with the simulated world's own record and with its seals.
#pragma once

#include <filesystem>
#include <string>

#include "replay/audit.h"

namespace firn::replay {

/// @param seal digest that one of the run's seals must have; empty: any
/// @throws UsageError, ConfigError: records that cannot be read, of a run whose seals are whole
AuditVerdict audit_run(const std::filesystem::path& run, const std::string& seal = {});

/// The same without the seals, of a print that has just ended and is not sealed yet.
AuditVerdict audit_records(const std::filesystem::path& run);

}  // namespace firn::replay
