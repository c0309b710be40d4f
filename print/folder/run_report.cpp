#include "print/folder/run_report.h"

#include <cmath>

#include "config/labs.h"
#include "print/print_judge.h"
#include "runs/folder/config_change.h"

namespace firn {
namespace {

Experiment recorded_experiment(const std::filesystem::path& run) {
  try {
    return parse_experiment(runs::recorded_config(run), "the recorded configuration");
  } catch (const std::exception&) {  // replay reports the fault
    return {};
  }
}

std::optional<runs::MapError> error_of(const report::LayerRow& row) {
  constexpr double kUm = 1e3;  // per mm
  if (std::isnan(row.rms_mm)) return std::nullopt;
  return runs::MapError{
      .mean_um = row.mean_error_mm * kUm, .rms_um = row.rms_mm * kUm, .std_um = row.std_mm * kUm};
}

}  // namespace

report::RunData run_data(const Product& product, const std::filesystem::path& run) {
  const Experiment e = recorded_experiment(run);
  report::RunData data = report::read_run_data(run, *print_lab(product, e).report);
  data.words = lab_words(e.lab.kind);
  if (data.result && !data.result->tolerance_um && !data.layers.empty()) {  // an older program printed
    PrintJudge judge(product, e, 0.0);
    judge.take(error_of(data.layers.back()));
    judge.judge(*data.result);
  }
  return data;
}

}  // namespace firn
