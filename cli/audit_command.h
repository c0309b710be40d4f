// run_audit compares the nodes' records of a run with the simulated world's own record.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "config/experiment.h"
#include "replay/audit.h"

namespace firn {

class OptionSet;

struct AuditCommandOptions {
  std::string run;   ///< run folder
  std::string seal;  ///< digest that one of the run's seals must have; empty: any
  bool json = false;
};

/// world.rec of a run of `experiment`; nothing where there is none (a real lab).
std::optional<replay::WorldTruth> read_world_truth(const std::filesystem::path& run,
                                                   const Experiment& experiment);

/// @param seal as AuditCommandOptions
/// @throws UsageError, ConfigError
replay::AuditVerdict audit_verdict(const std::filesystem::path& run, const std::string& seal = {});

/// @returns 0 clean, 1 any violation, 2 usage
int run_audit(const AuditCommandOptions& options);

/// Declares the arguments.
void declare_audit(OptionSet& options);

}  // namespace firn
