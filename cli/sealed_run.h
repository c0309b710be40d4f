// use_sealed_run holds a run that a command learns from against its seals.
#pragma once

#include <string>

namespace firn {

class OptionSet;

/// Holds the run folder against its seals.
/// @param unsealed the user wants the run nevertheless: stderr tells where it differs
/// @throws UsageError naming the first difference
void use_sealed_run(const std::string& run, bool unsealed);

/// Declares --unsealed.
void declare_unsealed(OptionSet& options, bool& unsealed);

}  // namespace firn
