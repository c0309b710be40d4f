#include "cli/report_command.h"

#include <unistd.h>

#include <cstdio>
#include <deque>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "cli/replay_command.h"
#include "config/fields.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "print/folder/run_report.h"
#include "print/import/imported_run.h"
#include "replay/audit_run.h"
#include "report/run/differing_parameters.h"
#include "report/run/metrics.h"
#include "report/run/report_page.h"
#include "runs/folder/config_change.h"
#include "runs/folder/incarnation_seal.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/truth_check.h"

namespace firn {
namespace {

std::string verdict_of(const Product& product, const std::string& run, bool no_replay) {
  if (no_replay) return {};
  if (is_imported(run)) return "imported, not replayable";
  ReplayCommandOptions options;
  options.run = run;
  options.run_python = replay::RunPython::kNever;
  const replay::RunVerdict verdict = replay_verdict(product, options);
  std::string said = verdict.identical() ? "identical" : "differs";
  for (const replay::NodeVerdict& node : verdict.not_replayed)
    said += ", " + node.name + " (Python) not replayed";
  return said;
}

// A run whose world told nothing is audited by its own records, and the verdict says so.
std::string audit_of(const std::string& run) {
  if (is_imported(run)) return "imported: there are no passes to audit";
  return replay::audit_words(replay::audit_run(run));
}

// Returns the run's data; the provenance ends with its seal, or with the reasons to doubt it.
report::RunData sealed_data(const Product& product, const std::string& run, bool unsealed) {
  std::string seal;
  for (const std::string& line : runs::require_seals(run, unsealed))
    seal += (seal.empty() ? "" : "; ") + line;
  const runs::TruthCheck truth = runs::check_truth(run);
  if (!truth.differs.empty() && !unsealed)
    throw UsageError(run + ": " + truth.differs.front() + "; --unsealed shows the run without its truth");
  report::RunData data = run_data(product, run);
  if (!truth.differs.empty()) {
    data.truth.reset();
    for (report::LayerRow& row : data.layers) {
      row.truth.reset();
      row.true_outline.reset();
    }
    if (data.ice) {
      data.ice->field.reset();
      for (report::IceInterval& i : data.ice->intervals) i.truth.reset();
    }
    seal += (seal.empty() ? "" : "; ") + truth.differs.front() + "; no truth is shown";
  }
  data.provenance.emplace_back("seal", seal.empty() ? "whole" : seal);
  return data;
}

bool writable(const std::string& run) { return ::access(run.c_str(), W_OK) == 0; }

// metrics.csv, and the page if it is in the run folder.
void seal_made(const std::filesystem::path& run, const std::filesystem::path& page) {
  std::vector<std::string> files{RunPaths::kMetrics};
  if (std::filesystem::weakly_canonical(page).parent_path() == std::filesystem::weakly_canonical(run))
    files.push_back(page.filename().string());
  runs::seal_derived(run, files);
}

std::vector<Experiment> recorded_experiments(const std::vector<std::string>& runs) {
  std::vector<Experiment> experiments;
  for (const std::string& run : runs)
    experiments.push_back(parse_experiment(runs::recorded_config(run), run + ": recorded configuration"));
  return experiments;
}

// A run that is given twice is locked once.
std::deque<runs::RunLock> hold(const std::vector<std::string>& runs) {
  std::deque<runs::RunLock> held;
  std::set<std::filesystem::path> seen;
  for (const std::string& run : runs) {
    runs::require_run(run);
    if (seen.insert(std::filesystem::weakly_canonical(run)).second)
      held.emplace_back(run, writable(run) ? runs::RunUse::kReport : runs::RunUse::kRead);
  }
  return held;
}

}  // namespace

void write_report(const Product& product, const ReportOptions& options) {
  if (!options.verdicts.empty() && options.verdicts.size() != options.runs.size())
    throw UsageError("a report needs one verdict for each run, or none");
  const std::deque<runs::RunLock> held = hold(options.runs);
  std::vector<report::ReportRun> runs;
  try {
    for (std::size_t n = 0; n < options.runs.size(); ++n) {
      const std::string& run = options.runs[n];
      runs.push_back(
          {sealed_data(product, run, options.unsealed),
           options.verdicts.empty() ? verdict_of(product, run, options.no_replay) : options.verdicts[n],
           audit_of(run)});
      if (!writable(run)) continue;  // an archive: the page is all that is made
      write_file_atomically(RunPaths(run).metrics_path(), report::metrics_csv(runs.back().data));
    }
    write_file_atomically(
        options.output,
        report::report_page(runs, report::differing_parameters(recorded_experiments(options.runs))));
    for (const std::string& run : options.runs)
      if (writable(run)) seal_made(run, options.output);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

int run_report(const Product& product, const ReportOptions& options) {
  write_report(product, options);
  if (options.json)
    std::puts(nlohmann::ordered_json{{"report", options.output}, {"runs", options.runs}}.dump(2).c_str());
  else
    std::printf("%s\n", options.output.c_str());
  return kOk;
}

void declare_report(OptionSet& options) {
  auto& o = options.calls(run_report);
  options.option("RUN", o.runs, "run folders").required();
  options.option("-o,--output", o.output, "HTML file").show_default();
  options.flag("--no-replay", o.no_replay,
               "do not replay the runs for a verdict: seconds instead of minutes for long ones");
  options.flag("--unsealed", o.unsealed,
               "show runs that are not as they were sealed, and say so on the page");
  options.json_flag(o.json);
}

}  // namespace firn
