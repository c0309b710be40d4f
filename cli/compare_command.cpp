#include "cli/compare_command.h"

#include <fmt/core.h>
#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>

#include "cli/commands.h"
#include "cli/compare_show.h"
#include "cli/option_set.h"
#include "config/include.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "report/study/study_answer.h"
#include "report/study/study_page.h"
#include "report/study/study_profile.h"
#include "runs/folder/run_folder.h"
#include "runtime/build_info.h"
#include "runtime/result_fingerprint.h"
#include "studies/compare/recorded_study.h"
#include "studies/compare/study_runner.h"

namespace firn {
namespace {

std::filesystem::path make_folder(const std::string& output, const std::string& name) {
  const std::filesystem::path folder =
      output.empty() ? std::filesystem::path("runs") / ("study-" + name) : std::filesystem::path(output);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    throw UsageError(folder.string() + ": no study folder can be made there");
  return folder;
}

// Reports the earlier prints of the folder.
void tell_of_the_past(const StudyPlan& plan, const StudyJournal& journal) {
  std::set<std::string> wanted;
  for (const StudyCell& c : plan.cells) wanted.insert(c.digest);
  std::size_t found = 0;
  for (const std::string& digest : wanted) found += journal.find(digest) != nullptr;
  if (found > 0) fmt::print(stderr, "{} of {} prints are on record\n", found, wanted.size());
  if (journal.size() > found)
    fmt::print(stderr, "{} results in the folder are of other settings or of another build: kept, not used\n",
               journal.size() - found);
  if (journal.damaged() > 0)
    fmt::print(stderr, "torn or damaged lines of the record: {}; these prints are made anew\n",
               journal.damaged());
}

using Provenance = std::vector<std::pair<std::string, std::string>>;

Provenance provenance(const Provenance& data, const std::string& trial) {
  Provenance all{
      {"build", build_commit()}, {"sources", build_sources()}, {"platform", platform_description()},
      {"results", fmt::format("{:016x}", digest_of(result_fingerprint()))}};
  all.insert(all.end(), data.begin(), data.end());
  all.emplace_back("intervals", "BCa bootstrap, 10,000 resamples of " + trial + "s, keyed");
  all.emplace_back(
      "tests",
      "sign-flip tests of the paired differences and of failed prints, two-sided; Holm's adjustment over all "
      "pairs of schemes");
  return all;
}

Provenance provenance(const StudyPlan& plan) {
  const auto& seeds = plan.study.seeds;
  const auto [low, high] = std::minmax_element(seeds.begin(), seeds.end());
  Provenance told{{"experiment", plan.study.experiment.empty() ? "the defaults" : plan.study.experiment},
                  {"seeds", fmt::format("{} from {} to {}", seeds.size(), *low, *high)}};
  if (!plan.study.lab.empty()) told.emplace_back("lab", plan.study.lab.string());
  return provenance(told, "seed");
}

// That a seed fixes for all schemes.
std::string same_nature(const StudyLab& lab) {
  if (&lab == &aerosol_study_lab()) return "the atomizer's output drifts and wanders alike in both";
  if (&lab == &ice_study_lab()) return "valves, bed and instruments deviate alike in both";
  return "the n-th droplet of a layer on a cell has one fate whatever scheme fires it";
}

using Settings = std::vector<report::DifferingParameter>;

int write_results(const std::filesystem::path& folder, const report::StudyTable& table, const Settings& arms,
                  const Settings& parts, const Provenance& told, const std::string& nature, bool json) {
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
  return analysis.ranking.empty() ? kFailed : kOk;
}

int compare_recorded(const CompareOptions& options, const Study& study, const std::filesystem::path& from) {
  if (!options.overrides.empty() || options.seeds > 0 || !options.lab.empty())
    throw UsageError("--set, --seeds, --lab: the runs are printed already");
  const RecordedStudy found = recorded_study(study, from);
  Provenance runs;
  for (std::size_t arm = 0; arm < found.runs.size(); ++arm)
    runs.emplace_back("runs of " + study.arms[arm].name, found.runs[arm]);
  return write_results(make_folder(options.output, study.name), found.table, found.settings, {},
                       provenance(runs, found.table.trial), "", options.json);
}

std::atomic<bool> interrupted{false};

}  // namespace

int compare(const CompareOptions& options, const StudyLab& lab, const std::atomic<bool>* stop) {
  if (options.threads < 0) throw UsageError("--threads must be 0 or more");
  const std::filesystem::path file = options.study;
  Study study = load_study(file);
  study.lab = options.lab;
  study.overrides.insert(study.overrides.end(), options.overrides.begin(), options.overrides.end());
  if (options.seeds > 0) {
    study.seeds.clear();
    for (int s = 1; s <= options.seeds; ++s) study.seeds.push_back(std::uint64_t(s));
  }
  const StudyPlan plan = plan_study(std::move(study), file.parent_path(), lab, options.study);
  const std::filesystem::path folder = make_folder(options.output, plan.study.name);
  StudyJournal journal(folder / "results.journal", lab);
  tell_of_the_past(plan, journal);
  write_file_atomically(folder / "study.toml", read_config_text(file));

  if (const std::string few = report::few_seeds_note(plan.study.arms.size(), plan.study.seeds.size(), "seed");
      !few.empty())
    fmt::print(stderr, "{}\n", few);
  std::size_t left = 0;
  for (const StudyCell& c : plan.cells) left += journal.find(c.digest) == nullptr;
  StudyProgress progress(left);
  StudyRunOptions run;
  run.threads = options.threads;
  run.stop = stop;
  run.progress = [&](std::size_t done, std::size_t failed) { progress.printed(done, failed); };
  const StudyRunSummary made = run_study(plan, journal, run);
  progress.done();
  if (made.done < made.to_do) {
    fmt::print(stderr, "interrupted after {} of {} prints; the same command goes on\n", made.done,
               made.to_do);
    return kInterrupted;
  }
  if (made.done > 0)
    fmt::print(stderr, "{} prints in {:.1f} s, {:.3f} s of processor time each\n", made.done,
               progress.elapsed_s(), made.cpu_s / double(made.done));

  return write_results(folder, study_table(plan, journal), differing_arms(plan), differing_parts(plan),
                       provenance(plan), same_nature(lab), options.json);
}

int run_compare(const CompareOptions& given) {
  CompareOptions options = given;
  if (options.words.size() > 1 || std::filesystem::is_directory(options.words.front()))
    return compare_recorded(options, study_of_runs(options.words), "");
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
  options.thread_option(o.threads);
  options.json_flag(o.json);
}

}  // namespace firn
