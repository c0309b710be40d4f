#include "cli/replay_command.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "cli/option_set.h"
#include "files/usage_error.h"
#include "print/folder/imported_run.h"
#include "print/folder/node_makers.h"
#include "print/folder/run_config.h"
#include "print/folder/run_folder.h"
#include "print/folder/running.h"
#include "print/folder/seal_check.h"
#include "print/folder/truth_check.h"
#include "print/inputs/python_input.h"
#include "replay/print_verdict.h"
#include "replay/replayer.h"
#include "runtime/build_info.h"

namespace firn {
namespace {

constexpr const char* kOpenLoop =
    "with other settings each decision is the one on the recorded surface, not what would have been printed "
    "next; firn tune RUN --keys KEY predicts prints";

// An edited experiment.toml is a way to replay with other settings, if it holds any: they are listed.
void mark_seals(const std::filesystem::path& run, replay::RunVerdict& verdict) {
  const auto marks = [&](const SealDifference& d) -> std::vector<std::string>& {
    const bool on_purpose = d.file == "experiment.toml" && !verdict.changed_settings.empty();
    return on_purpose ? verdict.notes : verdict.altered;
  };
  const SealCheck seals = check_seals(run);
  verdict.notes = seals.notes;
  for (const SealDifference& d : seals.differs) marks(d).push_back(to_text(d));
  verdict.altered.insert(verdict.altered.end(), seals.past_differs.begin(), seals.past_differs.end());
  const TruthCheck truth = check_truth(run);
  verdict.altered.insert(verdict.altered.end(), truth.differs.begin(), truth.differs.end());
}

// Before a divergence is looked for in the code: the interpreter may be another one.
void mark_python(const std::filesystem::path& run, replay::RunVerdict& verdict) try {
  const std::string difference = python_difference(RunFolder::open(run).inputs());
  if (!difference.empty()) verdict.notes.push_back(difference);
} catch (const std::exception&) {  // replay has named the input or the plug-in that is not there
}

}  // namespace

replay::RunVerdict replay_verdict(const ReplayCommandOptions& options) {
  refuse_running(options.run);
  refuse_imported(options.run, "firn replay");
  if (!std::isfinite(options.tolerance) || options.tolerance < 0)
    throw UsageError("--tolerance: a finite number >= 0 is wanted");
  std::vector<replay::NodeMaker> makers;
  for (const NamedMaker& m : taking_part(std::filesystem::path(options.run)))
    makers.push_back({info(m.id).name, m.make});
  replay::ReplayOptions r;
  r.makers = makers;
  r.only_node = options.node;
  r.tolerance = options.tolerance;
  r.threads = options.threads;
  r.stopwatch = options.stopwatch;
  r.commit = build_commit();
  r.platform = platform_description();
  try {
    for (const std::string& text : options.ignores) r.ignores.push_back(replay::parse_ignore(text));
    const ConfigChange config = config_change(options.run, recorded_config(options.run), options.overrides);
    r.change_config = config.change;
    replay::RunVerdict verdict = replay::replay_run(options.run, r);
    verdict.changed_settings = config.settings;
    mark_seals(options.run, verdict);
    mark_python(options.run, verdict);
    verdict.notes.insert(verdict.notes.end(), config.unread.begin(), config.unread.end());
    if (!config.settings.empty()) verdict.notes.push_back(kOpenLoop);
    return verdict;
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

int run_replay(const ReplayCommandOptions& options) {
  const replay::RunVerdict verdict = replay_verdict(options);
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
  options.json_flag(o.json);
}

}  // namespace firn
