#include "print/device/lab_experiment.h"

#include "config/error.h"
#include "config/include.h"

namespace firn {

Experiment load_lab_experiment(const std::string& file, const std::vector<std::string>& overrides) {
  try {
    return load_experiment(file, overrides, LabUse::kAlone);
  } catch (const ConfigError&) {
    std::vector<std::string> with_part = overrides;
    with_part.insert(with_part.begin(), "ice.mesh=\"-\"");
    try {
      return load_experiment(file, with_part, LabUse::kAlone);
    } catch (const ConfigError&) {
    }
    throw;
  }
}

}  // namespace firn
