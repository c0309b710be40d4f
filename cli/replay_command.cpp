#include "cli/replay_command.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "cli/commands.h"
#include "cli/option_set.h"
#include "files/run_paths.h"
#include "files/usage_error.h"
#include "print/folder/taking_part.h"
#include "print/import/imported_run.h"
#include "print/inputs/python_input.h"
#include "replay/print_verdict.h"
#include "replay/promise.h"
#include "replay/replayer.h"
#include "runs/folder/config_change.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/seal_check.h"
#include "runs/folder/truth_check.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"

namespace firn {
namespace {

constexpr const char* kOpenLoop =
    "with other settings each decision is the one on the recorded surface, not what would have been printed "
    "next; firn tune RUN --keys KEY predicts prints";

// An edited experiment.toml is a way to replay with other settings, if it holds any: they are listed.
void mark_seals(const std::filesystem::path& run, const runs::SealCheck& seals, replay::RunVerdict& verdict) {
  const auto marks = [&](const runs::SealDifference& d) -> std::vector<std::string>& {
    const bool on_purpose = d.file == RunPaths::kExperiment && !verdict.changed_settings.empty();
    return on_purpose ? verdict.notes : verdict.altered;
  };
  verdict.notes.insert(verdict.notes.end(), seals.notes.begin(), seals.notes.end());
  for (const runs::SealDifference& d : seals.differs) marks(d).push_back(to_text(d));
  verdict.altered.insert(verdict.altered.end(), seals.past_differs.begin(), seals.past_differs.end());
  const runs::TruthCheck truth = runs::check_truth(run);
  verdict.altered.insert(verdict.altered.end(), truth.differs.begin(), truth.differs.end());
}

// Before a divergence is looked for in the code: the interpreter may be another one.
void mark_python(const std::filesystem::path& run, replay::RunVerdict& verdict) try {
  const std::string difference = python_difference(runs::RunFolder::open(run).inputs());
  if (!difference.empty()) verdict.notes.push_back(difference);
} catch (const std::exception&) {  // replay has named the input or the plug-in that is not there
}

// Before any divergence as well: a function of a library may give other results here. Equal results on unlike
// computers are one platform.
std::string platform_of(const std::filesystem::path& run, std::vector<std::string>& differences) try {
  const runs::ProvenanceDocument recorded = runs::RunFolder::open(run).provenance();
  if (recorded.results.empty()) return platform_description();  // an older run: all there is to compare
  for (const std::string& function : differing_functions(recorded.results, result_fingerprint()))
    differences.push_back("function " + function + " gives other results here: recorded with " +
                          recorded.text("platform") + ", replayed with " + platform_description());
  return "";
} catch (const std::exception&) {  // replay names the file that is not there
  return platform_description();
}

// Before any divergence as well: another minor version may compute other bytes.
void mark_version(const std::filesystem::path& run, replay::RunVerdict& verdict) try {
  const runs::ProvenanceDocument recorded = runs::RunFolder::open(run).provenance();
  const std::string beyond =
      replay::beyond_promise(recorded.text("version"), recorded.text("commit"), build_version());
  if (!beyond.empty()) verdict.provenance.insert(verdict.provenance.begin(), beyond);
} catch (const std::exception&) {  // replay has named the file that is not there
}

}  // namespace

replay::RunVerdict replay_verdict(const Product& product, const ReplayCommandOptions& options) {
  const runs::RunLock still(options.run, runs::RunUse::kRead);
  const runs::SealCheck seals =
      runs::check_seals(options.run);  // names damage of packed files, as all commands do
  refuse_imported(options.run, "firn replay");
  if (!std::isfinite(options.tolerance) || options.tolerance < 0)
    throw UsageError("--tolerance: a finite number >= 0 is wanted");
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(product, std::filesystem::path(options.run)))
    makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions r;
  r.makers = makers;
  r.only_node = options.node;
  r.tolerance = options.tolerance;
  r.threads = options.threads;
  r.stopwatch = options.stopwatch;
  r.run_python = options.any_python ? replay::RunPython::kAlways : options.run_python;
  r.commit = build_commit();
  std::vector<std::string> platform_differs;
  r.platform = platform_of(options.run, platform_differs);
  try {
    for (const std::string& text : options.ignores) r.ignores.push_back(replay::parse_ignore(text));
    const runs::ConfigChange config =
        runs::config_change(options.run, runs::recorded_config(options.run), options.overrides);
    r.change_config = config.change;
    replay::RunVerdict verdict = replay::replay_run(options.run, r);
    if (verdict.nodes.empty() && !verdict.not_replayed.empty())
      throw UsageError(options.run + ": " + verdict.not_replayed.front().name +
                       " is Python code of the run (" + verdict.not_replayed.front().python +
                       "); --run-python runs it");
    verdict.changed_settings = config.settings;
    verdict.provenance.insert(verdict.provenance.begin(), platform_differs.begin(), platform_differs.end());
    mark_seals(options.run, seals, verdict);
    mark_version(options.run, verdict);
    if (options.run_python != replay::RunPython::kNever && verdict.not_replayed.empty())
      mark_python(options.run, verdict);
    verdict.notes.insert(verdict.notes.end(), config.unread.begin(), config.unread.end());
    if (!config.settings.empty()) verdict.notes.push_back(kOpenLoop);
    return verdict;
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

int run_replay(const Product& product, const ReplayCommandOptions& options) {
  const replay::RunVerdict verdict = replay_verdict(product, options);
  const std::string text = options.json ? replay::to_json(verdict) + "\n" : replay::to_text(verdict);
  std::fputs(text.c_str(), stdout);
  return verdict.exit_status();
}

void declare_replay(OptionSet& options) {
  auto& o = options.calls(run_replay);
  options.option("RUN", o.run, "run folder").required();
  options.option("--node", o.node, "this node only");
  options.option("--tolerance", o.tolerance, "numbers that differ by no more are equal");
  options
      .option("--ignore", o.ignores, "FIELD=reason: may differ; FIELD is LAYER_PLAN.iterations or iterations")
      .one_value_each();
  options.override_option(o.overrides, "KEY=VALUE, replays with a changed configuration");
  options.thread_option(o.threads);
  options.flag("--run-python", o.any_python,
               "run the Python code in a run of another user or host; docs/security.md");
  options.json_flag(o.json);
}

}  // namespace firn
