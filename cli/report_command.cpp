#include "cli/report_command.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "cli/audit_command.h"
#include "cli/option_set.h"
#include "cli/replay_command.h"
#include "config/fields.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "print/folder/imported_run.h"
#include "print/folder/run_config.h"
#include "print/folder/run_folder.h"
#include "print/folder/run_report.h"
#include "print/folder/run_seal.h"
#include "print/folder/truth_check.h"
#include "report/run/differing_parameters.h"
#include "report/run/metrics.h"
#include "report/run/report_page.h"

namespace firn {
namespace {

std::string verdict_of(const std::string& run, bool no_replay) {
  if (no_replay) return {};
  if (is_imported(run)) return "imported, not replayable";
  ReplayCommandOptions options;
  options.run = run;
  return replay_verdict(options).identical() ? "identical" : "differs";
}

// A run whose world told nothing is audited by its own records, and the verdict says so.
std::string audit_of(const std::string& run) {
  if (is_imported(run)) return "imported: there are no passes to audit";
  const replay::AuditVerdict v = audit_verdict(run);
  if (v.clean()) return v.with_world ? "clean" : "clean, without the world's record";
  return std::to_string(v.violations_total) + (v.violations_total == 1 ? " violation: " : " violations: ") +
         v.violations.front().what;
}

// Returns the run's data; the provenance ends with its seal, or with the reasons to doubt it.
replay::RunData sealed_data(const std::string& run, bool unsealed) {
  std::string seal;
  for (const std::string& line : require_seals(run, unsealed)) seal += (seal.empty() ? "" : "; ") + line;
  const TruthCheck truth = check_truth(run);
  if (!truth.differs.empty() && !unsealed)
    throw UsageError(run + ": " + truth.differs.front() + "; --unsealed shows the run without its truth");
  replay::RunData data = run_data(run);
  if (!truth.differs.empty()) {
    data.truth.reset();
    data.outline.reset();
    for (replay::LayerRow& row : data.layers) {
      row.truth.reset();
      row.outline.reset();
    }
    if (data.ice) {
      data.ice->field.reset();
      for (replay::IceInterval& i : data.ice->intervals) i.truth.reset();
    }
    seal += (seal.empty() ? "" : "; ") + truth.differs.front() + "; no truth is shown";
  }
  data.provenance.emplace_back("seal", seal.empty() ? "whole" : seal);
  return data;
}

bool writable(const std::string& run) { return ::access(run.c_str(), W_OK) == 0; }

// metrics.csv, and the page if it is in the run folder.
void seal_made(const std::filesystem::path& run, const std::filesystem::path& page) {
  std::vector<std::string> files{"metrics.csv"};
  if (std::filesystem::weakly_canonical(page).parent_path() == std::filesystem::weakly_canonical(run))
    files.push_back(page.filename().string());
  seal_derived(run, files);
}

std::vector<Experiment> recorded_experiments(const std::vector<std::string>& runs) {
  std::vector<Experiment> experiments;
  for (const std::string& run : runs)
    experiments.push_back(parse_experiment(recorded_config(run), run + ": recorded configuration"));
  return experiments;
}

}  // namespace

void write_report(const ReportOptions& options) {
  if (!options.verdicts.empty() && options.verdicts.size() != options.runs.size())
    throw UsageError("a report needs one verdict for each run, or none");
  std::vector<replay::ReportRun> runs;
  try {
    for (std::size_t n = 0; n < options.runs.size(); ++n) {
      const std::string& run = options.runs[n];
      runs.push_back({sealed_data(run, options.unsealed),
                      options.verdicts.empty() ? verdict_of(run, options.no_replay) : options.verdicts[n],
                      audit_of(run)});
      if (!writable(run)) continue;  // an archive: the page is all that is made
      const std::filesystem::path metrics = std::filesystem::path(run) / "metrics.csv";
      if (std::filesystem::is_symlink(metrics))
        throw UsageError(metrics.string() + ": is a link, no file of the run; it is left as it is");
      write_file_atomically(metrics, replay::metrics_csv(runs.back().data));
    }
    write_file_atomically(
        options.output, replay::report_page(runs, differing_parameters(recorded_experiments(options.runs))));
    for (const std::string& run : options.runs)
      if (writable(run)) seal_made(run, options.output);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

int run_report(const ReportOptions& options) {
  write_report(options);
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
