// firn audit RUN: the nodes' records against what truly happened in the simulated world.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/experiment.h"
#include "replay/audit.h"

namespace firn {

struct AuditCommandOptions {
  std::string run;  ///< run folder
  bool json = false;
};

/// world.rec of a run of `experiment`; nothing where there is none (a real lab).
std::optional<replay::WorldTruth> read_world_truth(const std::filesystem::path& run,
                                                   const Experiment& experiment);

/// @throws UsageError, ConfigError
replay::AuditVerdict audit_verdict(const std::filesystem::path& run);

/// @returns 0 clean, 1 any violation, 2 usage
int run_audit(const AuditCommandOptions& options);

}  // namespace firn
