#include "cli/sealed_run.h"

#include <fmt/core.h>

#include "cli/option_set.h"
#include "runs/folder/seal_check.h"

namespace firn {

std::unique_ptr<runs::RunLock> use_sealed_run(const std::string& run, bool unsealed) {
  auto still = std::make_unique<runs::RunLock>(run, runs::RunUse::kRead);
  if (!unsealed)
    runs::require_seals(run, false);
  else
    for (const std::string& line : runs::check_seals(run).lines()) fmt::print(stderr, "{}: {}\n", run, line);
  return still;
}

void declare_unsealed(OptionSet& options, bool& unsealed) {
  options.flag("--unsealed", unsealed, "use a run that is not as it was sealed, with a warning");
}

}  // namespace firn
