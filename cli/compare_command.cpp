#include "cli/compare_command.h"

#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string_view>

#include "cli/commands.h"
#include "cli/compare_show.h"
#include "cli/make_study.h"
#include "cli/option_set.h"
#include "cli/user_config.h"
#include "config/include.h"
#include "config/study_labs.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "report/study/study_answer.h"
#include "report/study/study_page.h"
#include "report/study/study_profile.h"
#include "runs/find/query.h"
#include "runs/find/run_index.h"
#include "runs/folder/run_folder.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"
#include "studies/compare/declared_commit.h"
#include "studies/compare/recorded_study.h"
#include "studies/compare/study_runner.h"

namespace firn {
namespace {

std::filesystem::path folder_of(const std::string& output, const std::string& name) {
  if (!output.empty()) return output;
  return std::filesystem::path(default_runs_folder().folder) / ("study-" + name);
}

std::filesystem::path make_folder(const std::string& output, const std::string& name) {
  const std::filesystem::path folder = folder_of(output, name);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw UsageError(folder.string() + ": no study folder can be made there");
  return folder;
}

// The lab that each seed drew: a line for each seed, a column for each key; where the parts are worlds a line
// for each world and seed, and no value for a key that is not of the world.
std::string labs_csv(const Study& study) {
  const bool worlds = !study.worlds.file.empty();
  std::vector<std::string> keys;
  for (std::size_t part = 0; part < study.parts.size(); ++part)
    for (const KeyRange& prior : priors_of(study, part))
      if (std::ranges::find(keys, prior.key) == keys.end()) keys.push_back(prior.key);
  std::string csv = worlds ? "world,seed" : "seed";
  for (const std::string& key : keys) csv += "," + key;
  for (std::size_t part = 0; part < (worlds ? study.parts.size() : 1); ++part)
    for (const std::uint64_t seed : study.seeds) {
      csv += "\n" + (worlds ? study.parts[part].name + "," : "") + std::to_string(seed);
      const std::vector<std::string> lab = drawn_lab(study, part, seed);
      for (const std::string& key : keys) {
        const auto drawn =
            std::ranges::find_if(lab, [&](const std::string& d) { return d.starts_with(key + "="); });
        csv += "," + (drawn == lab.end() ? "" : drawn->substr(key.size() + 1));
      }
    }
  return csv + "\n";
}

void write_study_files(const std::filesystem::path& folder, const std::filesystem::path& file,
                       const Study& study) {
  write_file_atomically(folder / "study.toml", read_config_text(file));
  if (!priors_of(study, 0).empty()) write_file_atomically(folder / "labs.csv", labs_csv(study));
}

using Provenance = std::vector<std::pair<std::string, std::string>>;

Provenance provenance(const Provenance& data, const std::string& trial) {
  Provenance all{{"build", build_commit()},
                 {"sources", build_sources()},
                 {"platform", platform_description()},
                 {"results", fmt::format("{:016x}", digest_of(result_fingerprint()))}};
  all.insert(all.end(), data.begin(), data.end());
  all.emplace_back("intervals", "BCa bootstrap, 10,000 resamples of " + trial + "s, keyed");
  all.emplace_back(
      "tests",
      "sign-flip tests of the paired differences and of failed prints, two-sided; Holm's adjustment over all "
      "pairs of schemes");
  return all;
}

/// @param folder of the study file
Provenance provenance(const StudyPlan& plan, const std::filesystem::path& folder,
                      std::size_t of_other_platforms) {
  const auto& seeds = plan.study.seeds;
  const auto [low, high] = std::minmax_element(seeds.begin(), seeds.end());
  Provenance told{{"experiment", plan.study.experiment.empty() ? "the defaults" : plan.study.experiment},
                  {"seeds", fmt::format("{} from {} to {}", seeds.size(), *low, *high)}};
  if (!plan.study.lab.empty()) told.emplace_back("lab", plan.study.lab.string());
  if (const StudyWorlds& worlds = plan.study.worlds; !worlds.file.empty()) {
    told.emplace_back("worlds", worlds.name + ", " + std::string(kLabSetWords[std::size_t(worlds.use)]) +
                                    " labs, declared in " + worlds.file);
    told.emplace_back("commit of the declaration", declared_commit(folder / worlds.file));
    for (const DeclaredGoal& goal : worlds.goals) told.emplace_back("goal " + goal.name, goal.says);
    for (const StudyEntry& world : plan.study.parts) {
      std::string ranges;
      for (const KeyRange& prior : world.priors) ranges += "; " + prior.key + " " + prior.words();
      told.emplace_back("world " + world.name, world.source + ranges);
    }
  }
  for (const KeyRange& prior : plan.study.priors)
    told.emplace_back(prior.key,
                      prior.words() + "; drawn for each seed, the same for all schemes (labs.csv)");
  if (of_other_platforms > 0)
    told.emplace_back("other platforms", counted(of_other_platforms, "result") +
                                             " of a platform whose library functions give other results");
  return provenance(told, "seed");
}

// That a seed fixes for all schemes.
std::string same_nature(const StudyLab& lab) {
  if (&lab == &aerosol_study_lab()) return "the atomizer's output drifts and wanders alike in both";
  if (&lab == &ice_study_lab()) return "valves, bed and instruments deviate alike in both";
  return "the n-th droplet of a layer on a cell has one fate whatever scheme fires it";
}

using Settings = std::vector<report::DifferingParameter>;

// The scheme that must not be worse, and the one beside it: "A worse than B".
struct FailIf {
  std::size_t a = 0, b = 0;
};

std::optional<FailIf> parse_fail_if(const std::string& text, const std::vector<StudyEntry>& arms) {
  if (text.empty()) return std::nullopt;
  constexpr std::string_view kBetween = " worse than ";
  const std::size_t at = text.find(kBetween);
  const auto arm = [&](const std::string& name) {
    const auto found = std::ranges::find(arms, name, &StudyEntry::name);
    std::string known;
    for (const StudyEntry& a : arms) known += (known.empty() ? "" : ", ") + a.name;
    if (found == arms.end()) throw UsageError("--fail-if: no scheme '" + name + "'; there are " + known);
    return std::size_t(found - arms.begin());
  };
  if (at == text.npos) throw UsageError("--fail-if '" + text + "': \"A worse than B\" is wanted");
  return FailIf{arm(text.substr(0, at)), arm(text.substr(at + kBetween.size()))};
}

bool holds(const FailIf& f, const report::StudyAnalysis& analysis) {
  const report::ArmComparison& pair = analysis.primary(f.a, f.b);
  return pair.told_apart() && pair.better() == f.b;
}

int write_results(const std::filesystem::path& folder, const report::StudyTable& table, const Settings& arms,
                  const Settings& parts, const Provenance& told, const std::string& nature, bool json,
                  const std::optional<FailIf>& fail_if = {}) {
  report::StudyAnalysis analysis = report::analyse(table);
  const report::StudyTable shown = report::in_readable_units(table);
  const report::StudyAnalysis said = report::analyse(shown);
  analysis.answer = said.answer;
  const std::string summary = study_json(table, analysis, told);
  write_file_atomically(folder / "runs.csv", report::study_csv(table));
  write_file_atomically(folder / "summary.json", summary);
  if (const auto rows = report::profile_rows(table); !rows.empty())
    write_file_atomically(folder / "profile.csv", report::profile_csv(table, rows));
  write_file_atomically(folder / "report.html", report::study_page({shown, said, arms, parts, told, nature}));
  if (json)
    std::fputs(summary.c_str(), stdout);
  else
    std::fputs((study_text(shown, said, arms) + "\n" + (folder / "report.html").string() + "\n").c_str(),
               stdout);
  if (fail_if && !analysis.ranking.empty() && holds(*fail_if, analysis)) {
    fmt::print(stderr, "--fail-if holds: {} is worse than {}\n", table.arms[fail_if->a],
               table.arms[fail_if->b]);
    return kFailed;
  }
  return analysis.ranking.empty() ? kFailed : kOk;
}

int compare_recorded(const CompareOptions& options, const Study& study, const std::filesystem::path& from) {
  if (!options.overrides.empty() || options.seeds > 0 || !options.lab.empty())
    throw UsageError("--set, --seeds, --lab: the runs are printed already");
  if (const std::string option = options.needs_folder(); !option.empty())
    throw UsageError(option + ": the runs are printed already");
  const RecordedStudy found =
      recorded_study(study, from, options.layers.empty() ? LayerWindow{} : parse_window(options.layers));
  Provenance runs;
  for (std::size_t arm = 0; arm < found.runs.size(); ++arm)
    runs.emplace_back("runs of " + study.arms[arm].name, found.runs[arm]);
  return write_results(make_folder(options.output, study.name), found.table, found.settings, {},
                       provenance(runs, found.table.trial), "", options.json,
                       parse_fail_if(options.fail_if, study.arms));
}

std::atomic<bool> interrupted{false};

// The command of one shard, without its number.
std::vector<std::string> shard_words(const CompareOptions& options) {
  namespace fs = std::filesystem;
  std::vector<std::string> words{fs::read_symlink("/proc/self/exe").string(), "compare",
                                 fs::absolute(options.study).string(), "-o",
                                 fs::absolute(options.output).string()};
  const auto add = [&](const std::string& option, const std::string& value) {
    words.push_back(option);
    words.push_back(value);
  };
  if (options.seeds > 0) add("--seeds", std::to_string(options.seeds));
  if (!options.lab.empty()) add("--lab", fs::absolute(options.lab).string());
  for (const std::string& assignment : options.overrides) add("--set", assignment);
  return words;
}

}  // namespace

int compare(const CompareOptions& given, const StudyLab& lab, const std::atomic<bool>* stop) {
  CompareOptions options = given;
  if (!options.layers.empty())
    throw UsageError("--layers: is of runs on record, and " + options.study + " is a study to print");
  const std::filesystem::path file = options.study;
  Study study = load_study(file);
  study.lab = options.lab;
  study.overrides.insert(study.overrides.end(), options.overrides.begin(), options.overrides.end());
  if (options.seeds > 0) take_seeds(study, std::size_t(options.seeds));
  const StudyPlan plan = plan_study(std::move(study), file.parent_path(), lab, options.study);
  const std::optional<FailIf> fail_if = parse_fail_if(options.fail_if, plan.study.arms);
  options.output = folder_of(options.output, plan.study.name).string();
  StudyCall call{shard_words(options)};
  call.stop = stop;
  call.prepare = [&](const std::filesystem::path& folder) {
    write_study_files(folder, file, plan.study);
    if (const std::string few =
            report::few_seeds_note(plan.study.arms.size(), plan.study.seeds.size(), "seed");
        !few.empty())
      fmt::print(stderr, "{}\n", few);
  };
  const StudyEnd end = make_study(options, plan, call);
  if (!end.journal) return end.code;
  return write_results(
      options.output, study_table(plan, *end.journal), differing_arms(plan), differing_parts(plan),
      provenance(plan, file.parent_path(), options.any_platform() ? end.journal->of_other_platforms() : 0),
      same_nature(lab), options.json, fail_if);
}

namespace {

// The runs of folders of runs that meet a condition, in the order of their beginning.
std::vector<std::string> runs_where(const std::vector<std::string>& words, const std::string& where) try {
  const runs::Query query = runs::parse_query(where);
  const std::vector<std::filesystem::path> places(words.begin(), words.end());
  runs::RunIndex index(runs::user_index(), [](const std::string& line) { fmt::print(stderr, "{}\n", line); });
  index.refresh(places);
  std::vector<std::string> found;
  for (const runs::FoundRun& r : index.find(query, where, places)) found.push_back(r.folder.string());
  if (found.empty()) throw UsageError("--where: no run meets the condition");
  return found;
} catch (const runs::QueryError& e) {
  fmt::print(stderr, "{}", e.shown);
  throw UsageError(std::string("--where: ") + e.what());
}

}  // namespace

int run_compare(const CompareOptions& given) {
  CompareOptions options = given;
  if (!options.where.empty()) {
    options.words = runs_where(options.words, options.where);
    return compare_recorded(options, study_of_runs(options.words, options.by), "");
  }
  if (options.words.size() > 1 || std::filesystem::is_directory(options.words.front()))
    return compare_recorded(options, study_of_runs(options.words, options.by), "");
  if (!options.by.empty())
    throw UsageError("--by: is of runs on record, and " + options.words.front() + " is a study");
  options.study = options.words.front();
  const std::filesystem::path file = options.study;
  Study study = load_study(file);
  study.lab = options.lab;
  if (study.recorded()) return compare_recorded(options, study, file.parent_path());
  struct sigaction action {
  }, old_int{}, old_term{};
  action.sa_handler = [](int) { interrupted = true; };
  sigaction(SIGINT, &action, &old_int);
  sigaction(SIGTERM, &action, &old_term);
  const int code = compare(options, study_lab_of(study, file.parent_path()), &interrupted);
  sigaction(SIGINT, &old_int, nullptr);
  sigaction(SIGTERM, &old_term, nullptr);
  return code;
}

void declare_compare(OptionSet& options) {
  auto& o = options.calls(run_compare);
  options.option("STUDY", o.words, "study file; or folders of runs that were printed or imported").required();
  options.option("-o,--output", o.output, "study folder; default: runs/study-NAME");
  options.option("--seeds", o.seeds, "seeds 1..N instead of the study's").within(1, 1000000);
  options.option("--lab", o.lab, "lab file in place of the one that the study's experiment includes");
  options.override_option(o.overrides, "KEY=VALUE, for every print");
  declare_study(options, o, "prints");
  options.option("--where", o.where,
                 "CONDITION: runs on record in these folders that meet it; docs/commands/runs.md");
  options.option("--layers", o.layers,
                 "FIRST-LAST: of runs on record, means over these layers instead of the last maps");
  options.option("--by", o.by, "meta.KEY: groups runs on record by what was printed, not by scheme");
  options.option("--fail-if", o.fail_if, "\"A worse than B\": exit code 1 if the study tells so");
  options.json_flag(o.json);
}

}  // namespace firn
