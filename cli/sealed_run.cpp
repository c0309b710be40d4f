#include "cli/sealed_run.h"

#include <fmt/core.h>

#include "cli/option_set.h"
#include "print/folder/seal_check.h"

namespace firn {

void use_sealed_run(const std::string& run, bool unsealed) {
  for (const std::string& line : require_seals(run, unsealed)) fmt::print(stderr, "{}: {}\n", run, line);
}

void declare_unsealed(OptionSet& options, bool& unsealed) {
  options.flag("--unsealed", unsealed, "use a run that is not as it was sealed, with a warning");
}

}  // namespace firn
