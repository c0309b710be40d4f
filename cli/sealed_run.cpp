#include "cli/sealed_run.h"

#include <fmt/core.h>

#include "cli/option_set.h"
#include "print/folder/seal_check.h"

namespace firn {

void use_sealed_run(const std::string& run, bool unsealed) {
  if (!unsealed)
    require_seals(run, false);
  else
    for (const std::string& line : check_seals(run).lines()) fmt::print(stderr, "{}: {}\n", run, line);
}

void declare_unsealed(OptionSet& options, bool& unsealed) {
  options.flag("--unsealed", unsealed, "use a run that is not as it was sealed, with a warning");
}

}  // namespace firn
