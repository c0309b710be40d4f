#include "print/folder/run_report.h"

#include "print/folder/run_config.h"
#include "print/labs/print_labs.h"

namespace firn {
namespace {

Experiment recorded_experiment(const std::filesystem::path& run) {
  try {
    return parse_experiment(recorded_config(run), "the recorded configuration");
  } catch (const std::exception&) {  // replay reports the fault
    return {};
  }
}

}  // namespace

replay::RunData run_data(const std::filesystem::path& run) {
  const Experiment e = recorded_experiment(run);
  replay::RunData data = replay::read_run_data(run, *print_lab(e).report);
  if (const double um = print_lab(e).tolerance_um(e); um > 0.0) data.health.tolerance_mm = um * 1e-3;
  return data;
}

}  // namespace firn
