// use_sealed_run holds a run that a command learns from against its seals.
#pragma once

#include <memory>
#include <string>

#include "runs/folder/run_lock.h"

namespace firn {

class OptionSet;

/// Holds the run folder against its seals, and still for as long as the lock lives.
/// @param unsealed the user wants the run nevertheless: stderr tells where it differs
/// @throws UsageError naming the first difference
[[nodiscard]] std::unique_ptr<runs::RunLock> use_sealed_run(const std::string& run, bool unsealed);

/// Declares --unsealed.
void declare_unsealed(OptionSet& options, bool& unsealed);

}  // namespace firn
