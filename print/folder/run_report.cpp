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
  return replay::read_run_data(run, *print_lab(recorded_experiment(run)).report);
}

}  // namespace firn
