#include "cli/study_on.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <thread>

#include "cli/study_state.h"
#include "core/options/for_people.h"
#include "files/exit_codes.h"
#include "files/usage_error.h"
#include "print/progress.h"
#include "runtime/build_info.h"
#include "studies/compare/study_shards.h"
#include "studies/engines/parallel.h"
#include "studies/engines/slurm.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPause{200};
constexpr std::chrono::seconds kLook{3};  // at Slurm's queue, and at the folder
constexpr int kLookShare = 20;            // a look takes at most this part of the time
constexpr int kMostShards = 10'000;       // over ssh; of Slurm the cluster says

Clock::duration pause_after(Clock::duration look) {
  return std::max<Clock::duration>(kLook, kLookShare * look);
}

// A study, and the request about it.
struct Asked {
  const StudyOptions& options;
  const StudyWork& work;
  const StudyCall& call;
  fs::path folder;
  StudyPlatforms platforms;

  bool stopped() const { return call.stop && *call.stop; }
  std::unique_ptr<StudyJournal> on_record() const {
    auto journal = std::make_unique<StudyJournal>(work.values, platforms);
    take_journals(*journal, folder, {});
    return journal;
  }
  std::size_t to_do() const { return prints_to_do(work, *on_record(), {}).size(); }
};

// Kinds differ in time. Each of unknown time that is not on record is made once here, so that the shards can
// be measured out.
void time_kinds(const Asked& a) {
  const fs::path own = results_journal(a.folder);
  StudyJournal journal(own, a.work.values, a.platforms);
  take_journals(journal, a.folder, own);
  StudyRunOptions first;
  first.threads = a.options.threads;
  first.stop = a.call.stop;
  first.first_of_each = true;
  if (const auto count = prints_to_do(a.work, journal, first).size(); count > 0)
    fmt::print(stderr, "{} here, to know how long each kind takes\n", counted(count, a.work.noun));
  run_study(a.work, journal, first);
}

// The command of a shard; as many shards as the time that is left has chunks, and those of them that have
// something to do.
ShardCommand measured_out(const Asked& a, int most) {
  ShardCommand c;
  c.words = a.call.words;
  if (a.platforms == StudyPlatforms::kAny) c.words.insert(c.words.end(), {"--platform", "any"});
  const auto journal = a.on_record();
  const std::size_t prints = prints_to_do(a.work, *journal, {}).size();
  if (prints == 0) return c;
  const double chunks = std::ceil(seconds_left(a.work, *journal, {}).value_or(0.0) / a.options.chunk_s);
  c.shards = int(std::clamp(chunks, 1.0, std::min(double(prints), double(most))));
  c.wanted = shards_to_do(a.work, *journal, c.shards);
  return c;
}

std::size_t stopped_prints(const StudyWork& work, const StudyJournal& journal) {
  return std::size_t(std::ranges::count_if(cells_of(work, {}), [&](const StudyCell* c) {
    const StudyPrint* print = journal.find(c->digest);
    return print && !print->within.value_or(print->finished);
  }));
}

// Shows the results that come in until the engine is idle. @returns false: stopped before, where `stops`
bool wait_for(const Asked& a, bool stops, const std::function<bool()>& busy) {
  const std::size_t to_do = a.to_do();
  StudyProgress progress(to_do, a.work.noun);
  for (auto next = Clock::now(); busy(); std::this_thread::sleep_for(kPause)) {
    if (stops && a.stopped()) return false;
    if (Clock::now() < next) continue;
    const auto began = Clock::now();
    const auto journal = a.on_record();
    const std::size_t left = std::min(to_do, prints_to_do(a.work, *journal, {}).size());
    progress.made(to_do - left, stopped_prints(a.work, *journal));
    next = began + pause_after(Clock::now() - began);
  }
  return true;
}

RemoteEnd submit_to_slurm(const Asked& a, const std::string& partition) {
  const Slurm slurm(a.folder);
  if (a.options.cancel) {
    slurm.cancel();
    fmt::print("job {} is cancelled; what it made is on record\n", *slurm.job());
    return {false, kOk};
  }
  if (slurm.tasks().empty()) {
    const int most = slurm.most_shards();
    time_kinds(a);
    if (a.stopped()) return {false, kInterrupted};
    const ShardCommand command = measured_out(a, most);
    if (command.wanted.empty()) return {true, kOk};
    const std::string job = slurm.submit(command, partition);
    fmt::print(stderr, "submitted to Slurm as job {2}: {0} of about {1} s; what they say: {3}\n",
               counted(command.wanted.size(), "shard"), for_people(a.options.chunk_s), job,
               (a.folder / "slurm").string());
  } else {
    fmt::print(stderr, "job {} is at work already\n", *slurm.job());
  }
  if (a.options.detach) return {false, kOk};
  auto next = Clock::now();
  bool busy = true;
  const bool ended = wait_for(a, true, [&] {
    if (Clock::now() < next) return busy;
    const auto began = Clock::now();
    busy = !slurm.tasks().empty();
    next = began + pause_after(Clock::now() - began);
    return busy;
  });
  if (ended) return {true, kOk};
  fmt::print(stderr, "job {} goes on; the same command waits for it again, --cancel ends it\n", *slurm.job());
  return {false, kInterrupted};
}

RemoteEnd run_over_ssh(const Asked& a, const std::string& hosts) {
  if (a.options.detach || a.options.cancel)
    throw UsageError("--detach, --cancel: shards over ssh are this command's own; Ctrl-C ends them");
  Parallel parallel(a.folder, hosts);
  parallel.check(a.call.words.front(), build_name());
  time_kinds(a);
  if (a.stopped()) return {false, kInterrupted};
  const ShardCommand command = measured_out(a, kMostShards);
  if (command.wanted.empty()) return {true, kOk};
  fs::create_directories(a.folder / "shards");
  fmt::print(stderr, "{} of about {} s to {}\n", counted(command.wanted.size(), "shard"),
             for_people(a.options.chunk_s), hosts);
  const std::atomic<bool> never{false};
  std::future<int> failed = std::async(
      std::launch::async, [&] { return parallel.run(command, a.call.stop ? *a.call.stop : never); });
  wait_for(a, false, [&] { return failed.wait_for(std::chrono::seconds(0)) != std::future_status::ready; });
  if (const int shards = failed.get(); shards > 0)
    fmt::print(stderr, "{} failed: {}\n", counted(std::size_t(shards), "shard"),
               (a.folder / "parallel" / "errors.txt").string());
  if (a.stopped()) return {false, kInterrupted};
  return {true, kOk};
}

}  // namespace

RemoteEnd study_on(const StudyOptions& options, const StudyWork& work, const StudyCall& call) {
  const Asked a{options, work, call, fs::absolute(options.output),
                options.any_platform() ? StudyPlatforms::kAny : StudyPlatforms::kThis};
  const std::string engine = options.on.substr(0, options.on.find(':'));
  const std::string where = engine.size() < options.on.size() ? options.on.substr(engine.size() + 1) : "";
  RemoteEnd end;
  if (engine == "slurm")
    end = submit_to_slurm(a, where);
  else if (engine == "ssh" && !where.empty())
    end = run_over_ssh(a, where);
  else
    throw UsageError("--on " + options.on + ": must be slurm, slurm:PARTITION or ssh:HOST,HOST");
  if (!end.all_on_record) return end;
  const auto journal = a.on_record();
  const std::size_t left = prints_to_do(work, *journal, {}).size();
  if (left == 0) return end;
  fmt::print(stderr, "{} missing; the same command submits them again\n",
             left == 1 ? "1 " + work.noun + " is" : counted(left, work.noun) + " are");
  if (journal->of_other_platforms() > 0 && a.platforms == StudyPlatforms::kThis)
    fmt::print(
        stderr,
        "{} came from computers whose library functions give other results than this one's: --platform "
        "any counts them, and says so\n",
        counted(journal->of_other_platforms(), "result"));
  if (journal->of_other_builds() > 0)
    fmt::print(stderr, "{} came from another build and never count\n",
               counted(journal->of_other_builds(), "result"));
  return {false, kFailed};
}

std::string job_text(const fs::path& folder) try {
  const Slurm slurm(folder);
  const auto job = slurm.job();
  if (!job) return "";
  std::string states;
  for (const auto& [state, count] : slurm.tasks())
    states += fmt::format("{}{} {}", states.empty() ? "" : ", ", count, state);
  return fmt::format("Slurm's job {}: {}\n", *job, states.empty() ? "over" : states);
} catch (const UsageError& error) {
  return std::string("Slurm's job: ") + error.what() + "\n";
}

}  // namespace firn
