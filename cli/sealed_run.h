// use_sealed_run holds a run that a command learns from against its seals.
#pragma once

#include <string>

namespace firn {

class OptionSet;

/// Says on stderr where the run folder differs from its seals, and which parts no seal covers.
/// @param unsealed the user wants the run nevertheless
/// @throws UsageError naming the first difference
void use_sealed_run(const std::string& run, bool unsealed);

/// Declares --unsealed.
void declare_unsealed(OptionSet& options, bool& unsealed);

}  // namespace firn
