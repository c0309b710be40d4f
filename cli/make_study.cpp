#include "cli/make_study.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include "cli/study_on.h"
#include "cli/study_state.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "studies/compare/study_shards.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

// Tells the state of the folder while others may be writing into it; makes and locks nothing.
int tell_state(const StudyOptions& options, const StudyWork& work, const StudyShard& shard,
               StudyPlatforms platforms) {
  StudyJournal journal(work.values, platforms);
  take_journals(journal, options.output, {});
  const std::string text =
      options.json ? study_state_json(work, journal, shard) : study_state_text(work, journal, shard);
  std::fputs(text.c_str(), stdout);
  if (options.status && !options.json) std::fputs(job_text(options.output).c_str(), stdout);
  return kOk;
}

// Reports the earlier results of the folder.
void tell_of_the_past(const StudyWork& work, const StudyJournal& journal, bool any_platform) {
  const std::vector<const StudyCell*> wanted = cells_of(work, {});
  const auto found = std::size_t(
      std::ranges::count_if(wanted, [&](const StudyCell* c) { return journal.find(c->digest) != nullptr; }));
  if (found > 0) fmt::print(stderr, "{} of {} are on record\n", found, counted(wanted.size(), work.noun));
  if (journal.size() > found)
    fmt::print(stderr, "{} results in the folder are of other settings: kept, not used\n",
               journal.size() - found);
  if (journal.of_other_builds() > 0)
    fmt::print(stderr, "{} results in the folder are of another build: kept, not used\n",
               journal.of_other_builds());
  if (journal.of_other_platforms() > 0)
    fmt::print(stderr,
               "{} results in the folder are of a platform whose library functions give other results: {}\n",
               journal.of_other_platforms(),
               any_platform ? "used, as --platform any says" : "kept, not used; --platform any uses them");
  for (const StudyJournal::Damage& d : journal.damage()) fmt::print(stderr, "{}\n", damage_text(d));
}

// @returns false: interrupted
bool make_some(const StudyWork& work, StudyJournal& journal, const StudyRunOptions& how) {
  StudyRunOptions run = how;
  std::optional<StudyProgress> progress;
  const std::vector<const StudyCell*> to_make = prints_to_do(work, journal, run);
  if (!work.tells_progress(to_make)) {
    progress.emplace(to_make.size(), work.noun);
    run.progress = [&](std::size_t done, std::size_t failed) { progress->made(done, failed); };
  }
  const StudyRunSummary made = run_study(work, journal, run);
  if (!progress) return made.done == made.to_do;
  progress->done();
  if (made.done < made.to_do)
    fmt::print(stderr, "interrupted after {} of {}; the same command goes on\n", made.done,
               counted(made.to_do, work.noun));
  else if (made.done > 0)
    fmt::print(stderr, "{} in {:.1f} s, {:.3f} s of processor time each\n", counted(made.done, work.noun),
               progress->elapsed_s(), made.cpu_s / double(made.done));
  return made.done == made.to_do;
}

fs::path made_folder(const std::string& output) {
  std::error_code error;
  fs::create_directories(output, error);
  if (error || !fs::is_directory(output)) throw UsageError(output + ": no study folder can be made there");
  return output;
}

}  // namespace

StudyEnd make_study(const StudyOptions& options, const StudyWork& work, const StudyCall& call) {
  if (options.threads < 0) throw UsageError("--threads must be 0 or more");
  const StudyShard shard = options.shard.empty() ? StudyShard{} : parse_shard(options.shard);
  const StudyPlatforms platforms = options.any_platform() ? StudyPlatforms::kAny : StudyPlatforms::kThis;
  StudyRunOptions run;
  run.threads = options.threads;
  run.stop = call.stop;
  run.shard = shard;
  run.most = std::size_t(options.most);
  run.again = options.again;
  if (options.output.empty()) {
    if (const std::string option = options.needs_folder(); !option.empty())
      throw UsageError(option + ": is of results in a folder, and none is named");
    auto journal = std::make_unique<StudyJournal>(work.values);
    if (!make_some(work, *journal, run)) return {kInterrupted, nullptr};
    return {kOk, std::move(journal)};
  }
  if (options.status || options.dry_run) return {tell_state(options, work, shard, platforms), nullptr};
  const fs::path folder = made_folder(options.output);
  if (!options.on.empty()) {
    if (!options.shard.empty() || options.most > 0 || options.again)
      throw UsageError("--on: makes all " + work.noun +
                       "s that are missing, so --shard, --max, --again have no meaning");
    if (call.prepare) call.prepare(folder);
    const RemoteEnd end = study_on(options, work, call);
    if (!end.all_on_record) return {end.code, nullptr};
  } else if (options.detach || options.cancel) {
    throw UsageError("--detach, --cancel: are of --on slurm");
  }
  const std::optional<ShardFile> own =
      options.shard.empty() ? std::nullopt : std::optional<ShardFile>(std::in_place, folder, shard);
  const fs::path at_work = own ? own->at_work() : results_journal(folder);
  auto journal = std::make_unique<StudyJournal>(at_work, work.values, platforms);
  if (own) journal->take_only(cells_of(work, shard));
  take_journals(*journal, folder, at_work);
  tell_of_the_past(work, *journal, options.any_platform());
  if (!own && options.on.empty() && call.prepare) call.prepare(folder);
  if (!make_some(work, *journal, run)) return {kInterrupted, nullptr};
  StudyRunOptions rest;
  rest.shard = shard;
  if (const auto left = prints_to_do(work, *journal, rest).size(); left > 0) {
    fmt::print(stderr, "{} left; the same command goes on\n",
               left == 1 ? "1 " + work.noun + " is" : counted(left, work.noun) + " are");
    return {kOk, nullptr};
  }
  if (!own) return {kOk, std::move(journal)};
  fmt::print("{}\n", own->finish().string());
  return {kOk, nullptr};
}

}  // namespace firn
