#include "print/device/lab_experiment.h"

#include "config/error.h"
#include "config/include.h"

namespace firn {
namespace {

constexpr const char* kParts[] = {"ice.mesh=\"-\"", "aerosol.job=\"-\""};  // a lab's own file has none

}  // namespace

Experiment load_lab_experiment(const std::string& file, const std::vector<std::string>& overrides) {
  try {
    return load_experiment(file, overrides, LabUse::kAlone);
  } catch (const ConfigError&) {
    for (const char* part : kParts) {
      std::vector<std::string> with_part = overrides;
      with_part.insert(with_part.begin(), part);
      try {
        return load_experiment(file, with_part, LabUse::kAlone);
      } catch (const ConfigError&) {
      }
    }
    throw;
  }
}

}  // namespace firn
