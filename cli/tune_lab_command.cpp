#include "cli/tune_lab_command.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <set>
#include <system_error>
#include <thread>

#include "cli/make_study.h"
#include "cli/option_set.h"
#include "cli/sealed_run.h"
#include "cli/tune_pairs.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/progress.h"
#include "runs/folder/config_change.h"
#include "runs/folder/origin.h"
#include "runs/folder/run_folder.h"
#include "studies/compare/study_lab.h"
#include "studies/tune/print_journal.h"
#include "studies/tune/tune_answer.h"

namespace firn {
namespace {

using namespace tune;

constexpr double kFitShare = 0.41;  // of the budget

std::vector<TuneKey> keys_of(const TuneLabOptions& o, const Experiment& e) {
  if (o.keys.empty())
    throw UsageError("--keys: keys to tune are wanted, as control.smf.kp,control.smf.ki_star");
  std::vector<TuneKey> keys;
  std::set<std::string> names;
  for (const std::string& text : o.keys) {
    keys.emplace_back(text, e);
    if (!names.insert(keys.back().key()).second)
      throw UsageError("--keys: " + keys.back().key() + " is named twice");
  }
  return keys;
}

/// The goal's index, before the run's maps are read.
std::size_t goal_of(const std::string& run, const std::string& goal) {
  const std::string config = runs::recorded_config(runs::RunFolder::open(run).path());
  return goal_index(parse_recorded_experiment(config, run + ": the recorded configuration"), goal);
}

/// The prints that are tuned: the first run's part, with its settings but for the overrides.
RecordedRun start_of(const RecordedRun& run, const std::vector<std::string>& overrides) {
  RecordedRun start = run;
  if (overrides.empty()) return start;
  const std::string recorded = dump(run.experiment);
  const Experiment plain = parse_experiment(recorded, run.name);  // without the keys of other labs
  start.experiment = parse_experiment({{run.name, recorded}}, overrides);
  for (const ConfigDifference& d : differences(plain, start.experiment))
    if (!is_tuned_section(d.key)) throw UsageError("--set " + d.key + ": " + std::string(kTunedSections));
  check_inputs(full_product(), start.experiment, start.inputs);
  return start;
}

/// The search takes a minute: a place that cannot be written is told before it.
void require_place(const std::string& output) {
  const std::filesystem::path folder = std::filesystem::absolute(output).parent_path();
  std::error_code none;
  if (std::filesystem::is_directory(output, none))
    throw UsageError("--output " + output + ": is a folder, a file is wanted");
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw UsageError("--output " + output + ": cannot be written: " + std::strerror(errno));
}

std::optional<PrintJournal> known_prints(const std::string& file) try {
  if (file.empty()) return std::nullopt;
  return std::optional<PrintJournal>(std::in_place, file);
} catch (const UsageError& error) {
  throw UsageError(std::string("--state ") + error.what());
}

// Options that tell of the folder as it is.
std::string told_without_search(const StudyOptions& o) {
  return o.status ? "--status" : o.dry_run ? "--dry-run" : o.cancel ? "--cancel" : "";
}

// A shard prints the settings that are remembered, and answers nothing.
bool searches_nothing(const StudyOptions& o) { return !o.shard.empty() || !told_without_search(o).empty(); }

}  // namespace

int run_tune_lab(const TuneLabOptions& o) {
  if (const std::string option = o.study.output.empty() ? o.study.needs_folder() : ""; !option.empty())
    throw UsageError(option + ": is of the prints of --verify in the folder of --study, which is not named");
  if (!o.study.output.empty() && o.verify == 0)
    throw UsageError("--study: is the folder of the prints of --verify");
  if (o.runs.empty()) throw UsageError("a run is wanted, or 'smf' for the thesis's model of one point");
  if (!o.output.empty()) require_place(o.output);
  std::vector<RecordedRun> runs;
  std::size_t goal = 0;
  for (const std::string& run : o.runs) {
    const auto still = use_sealed_run(run, o.unsealed);
    runs::require_own_python(run, o.run_python);
    if (runs.empty()) goal = goal_of(run, o.goal);
    runs.push_back(RecordedRun::read(run));
  }
  const RecordedRun start = start_of(runs.front(), o.overrides);
  const std::vector<TuneKey> keys = keys_of(o, start.experiment);
  const TunedRuns tuned{o, runs, start, keys};
  const StudyCall call{o.study.on.empty() ? std::vector<std::string>{} : pair_words(o)};
  if (const auto settings = remembered_settings(tuned); settings && searches_nothing(o.study))
    return make_study(o.study, PromisePairs(start, keys, *settings), call).code;
  if (const std::string option = told_without_search(o.study); !option.empty())
    throw UsageError(option + ": " + o.study.output +
                     " remembers no settings of this command; without the option it searches them first");
  std::optional<PrintJournal> known = known_prints(o.state);
  const int threads =
      o.study.threads > 0 ? o.study.threads : int(std::max(1u, std::thread::hardware_concurrency()));
  const int promised = o.verify > 0 ? o.verify : o.promised;
  JobProgress progress("firn tune");
  const auto part = [&](double from, double to) {
    return Progress([&progress, from, to](double share, const std::string& about) {
      progress.show(from + (to - from) * share, about);
    });
  };
  const int fit_prints = int(kFitShare * o.budget);
  PrintJournal* const journal = known ? &*known : nullptr;
  if (journal && journal->known() + journal->damaged() > 0)
    fmt::print(stderr, "firn tune: {} prints are known from {}, {} of its lines were cut short\n",
               journal->known(), o.state, journal->damaged());
  const FittedLab lab = fit_lab(runs, {o.seed, threads, fit_prints, part(0.0, 0.4), journal});
  TuneAnswer answer{runs,     keys,  study_lab_of(start.experiment).metrics[goal].name, lab, {}, {}, {},
                    promised, o.seed};
  if (lab.check.passed()) {
    answer.advice = advise(
        lab, start, keys, {goal, o.seed, threads, o.budget - fit_prints, promised, part(0.4, 0.95), journal});
    answer.next =
        next_prints(lab, runs.front(),
                    {.seed = o.seed, .threads = threads, .progress = part(0.95, 1.0), .journal = journal});
  }
  progress.done();
  if (answer.advice && o.verify > 0) {
    const PairSettings settings{answer.advice->old_setting, answer.advice->new_setting, o.verify, o.seed};
    const PromisePairs pairs(start, keys, settings);
    remember_settings(tuned, settings);
    const StudyEnd end = make_study(o.study, pairs, call);
    if (!end.journal) return end.code;
    answer.verification = verification_of(pairs, *end.journal, answer.advice->promise, goal);
  }
  if (!o.output.empty()) write_file_atomically(o.output, tune_page(answer));
  std::fputs((o.study.json ? tune_json(answer) : tune_text(answer)).c_str(), stdout);
  const bool kept = !answer.verification || answer.verification->held;
  return answer.advice && kept ? kOk : kFailed;
}

void declare_tune_lab(OptionSet& options) {
  auto& o = options.calls(run_tune_lab);
  options.option("RUN", o.runs, "run folders of one laboratory; the first one's part and settings are tuned");
  options.option("--keys", o.keys, "KEY or KEY=LOW:HIGH, separated by commas").separated_by(',');
  options.override_option(o.overrides,
                          "KEY=VALUE of the prints that are tuned, as control.scheme=mpc; the logs' own "
                          "settings are those recorded");
  options.option("--goal", o.goal, "metric of the true surface to minimise, as firn compare names it")
      .show_default();
  options.option("--budget", o.budget, "simulated prints, about").show_default().within(300, 100000);
  options.option("--verify", o.verify, "prints N pairs with the old and the new setting").within(2, 10000);
  options.option("--study", o.study.output,
                 "folder of the prints of --verify: the same command goes on, and shards print for it");
  options.option("--promise", o.promised, "without --verify: the promise is about the mean of N prints")
      .show_default()
      .within(1, 10000);
  options.option("--seed", o.seed, "of the simulated prints").show_default();
  options.option("--state", o.state, "file that remembers simulated prints: the same call goes on from it");
  options.option("-o,--output", o.output, "page with predicted curves, HTML");
  declare_unsealed(options, o.unsealed);
  options.flag("--run-python", o.run_python,
               "run the Python code in a run of another user or host; docs/security.md");
  declare_study(options, o.study, "prints of --verify");
  options.json_flag(o.study.json);
}

}  // namespace firn
