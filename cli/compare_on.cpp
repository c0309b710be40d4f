#include "cli/compare_on.h"

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
constexpr int kLookShare = 20;            // a look at the folder takes at most this part of the time
constexpr int kMostShards = 10'000;       // over ssh; of Slurm the cluster says

std::unique_ptr<StudyJournal> on_record(const StudyPlan& plan, const fs::path& folder,
                                        StudyPlatforms platforms) {
  auto journal = std::make_unique<StudyJournal>(*plan.lab, platforms);
  take_journals(*journal, folder, {});
  return journal;
}

// Schemes differ in time. Each that has no print on record makes one here, so that the shards can be measured
// out.
void time_schemes(const CompareOptions& options, const StudyPlan& plan, const fs::path& folder,
                  StudyPlatforms platforms, const std::atomic<bool>* stop) {
  StudyJournal journal(results_journal(folder), *plan.lab, platforms);
  take_journals(journal, folder, results_journal(folder));
  StudyRunOptions first;
  first.threads = options.threads;
  first.stop = stop;
  first.first_of_each = true;
  if (const auto count = prints_to_do(plan, journal, first).size(); count > 0)
    fmt::print(stderr, "{} here, to know how long each scheme takes\n", counted(count, "print"));
  run_study(plan, journal, first);
}

// The command of a shard; as many shards as the time that is left has chunks, and those of them that have
// prints to do.
ShardCommand measured_out(const CompareOptions& options, const StudyPlan& plan, const fs::path& folder,
                          StudyPlatforms platforms, int most) {
  ShardCommand c;
  c.words = {fs::read_symlink("/proc/self/exe").string(), "compare", fs::absolute(options.study).string(),
             "-o", fs::absolute(folder).string()};
  const auto add = [&](const std::string& option, const std::string& value) {
    c.words.push_back(option);
    c.words.push_back(value);
  };
  if (options.seeds > 0) add("--seeds", std::to_string(options.seeds));
  if (!options.lab.empty()) add("--lab", fs::absolute(options.lab).string());
  for (const std::string& assignment : options.overrides) add("--set", assignment);
  if (platforms == StudyPlatforms::kAny) add("--platform", "any");
  const auto journal = on_record(plan, folder, platforms);
  const std::size_t prints = prints_to_do(plan, *journal, {}).size();
  if (prints == 0) return c;
  const double chunks = std::ceil(seconds_left(plan, *journal, {}).value_or(0.0) / options.chunk_s);
  c.shards = int(std::clamp(chunks, 1.0, std::min(double(prints), double(most))));
  c.wanted = shards_to_do(plan, *journal, c.shards);
  return c;
}

std::size_t stopped_prints(const StudyPlan& plan, const StudyJournal& journal) {
  return std::size_t(std::ranges::count_if(cells_of(plan, {}), [&](const StudyCell* c) {
    const StudyPrint* print = journal.find(c->digest);
    return print && !print->within.value_or(print->finished);
  }));
}

// Shows the prints that come in until the engine is idle. @returns false: stopped before
bool wait_for(const StudyPlan& plan, const fs::path& folder, StudyPlatforms platforms, std::size_t to_do,
              const std::atomic<bool>* stop, const std::function<bool()>& busy) {
  StudyProgress progress(to_do);
  for (auto next = Clock::now(); busy(); std::this_thread::sleep_for(kPause)) {
    if (stop && *stop) return false;
    if (Clock::now() < next) continue;
    const auto began = Clock::now();
    const auto journal = on_record(plan, folder, platforms);
    const std::size_t left = std::min(to_do, prints_to_do(plan, *journal, {}).size());
    progress.printed(to_do - left, stopped_prints(plan, *journal));
    next = Clock::now() + std::max<Clock::duration>(kLook, kLookShare * (Clock::now() - began));
  }
  return true;
}

RemoteEnd submit_to_slurm(const CompareOptions& options, const StudyPlan& plan, const fs::path& folder,
                          StudyPlatforms platforms, const std::atomic<bool>* stop,
                          const std::string& partition) {
  const Slurm slurm(folder);
  if (options.cancel) {
    slurm.cancel();
    fmt::print("job {} is cancelled; what it printed is on record\n", *slurm.job());
    return {false, kOk};
  }
  if (slurm.tasks().empty()) {
    const int most = slurm.most_shards();
    time_schemes(options, plan, folder, platforms, stop);
    if (stop && *stop) return {false, kInterrupted};
    const ShardCommand command = measured_out(options, plan, folder, platforms, most);
    if (command.wanted.empty()) return {true, kOk};
    const std::string job = slurm.submit(command, partition);
    fmt::print(stderr, "submitted to Slurm as job {2}: {0} of about {1} s; what they say: {3}\n",
               counted(command.wanted.size(), "shard"), for_people(options.chunk_s), job,
               (folder / "slurm").string());
  } else {
    fmt::print(stderr, "job {} is at work already\n", *slurm.job());
  }
  if (options.detach) return {false, kOk};
  auto next = Clock::now();
  bool busy = true;
  const bool ended = wait_for(plan, folder, platforms,
                              prints_to_do(plan, *on_record(plan, folder, platforms), {}).size(), stop, [&] {
                                if (Clock::now() < next) return busy;
                                busy = !slurm.tasks().empty();
                                next = Clock::now() + kLook;
                                return busy;
                              });
  if (ended) return {true, kOk};
  fmt::print(stderr, "job {} goes on; the same command waits for it again, --cancel ends it\n", *slurm.job());
  return {false, kInterrupted};
}

RemoteEnd run_over_ssh(const CompareOptions& options, const StudyPlan& plan, const fs::path& folder,
                       StudyPlatforms platforms, const std::atomic<bool>* stop, const std::string& hosts) {
  if (options.detach || options.cancel)
    throw UsageError("--detach, --cancel: shards over ssh are this command's own; Ctrl-C ends them");
  Parallel parallel(fs::absolute(folder), hosts);
  parallel.check(fs::read_symlink("/proc/self/exe").string(), build_name());
  time_schemes(options, plan, folder, platforms, stop);
  if (stop && *stop) return {false, kInterrupted};
  const ShardCommand command = measured_out(options, plan, folder, platforms, kMostShards);
  if (command.wanted.empty()) return {true, kOk};
  fs::create_directories(folder / "shards");
  fmt::print(stderr, "{} of about {} s to {}\n", counted(command.wanted.size(), "shard"),
             for_people(options.chunk_s), hosts);
  const std::atomic<bool> never{false};
  std::future<int> failed =
      std::async(std::launch::async, [&] { return parallel.run(command, stop ? *stop : never); });
  const std::size_t to_do = prints_to_do(plan, *on_record(plan, folder, platforms), {}).size();
  wait_for(plan, folder, platforms, to_do, nullptr,
           [&] { return failed.wait_for(std::chrono::seconds(0)) != std::future_status::ready; });
  if (const int shards = failed.get(); shards > 0)
    fmt::print(stderr, "{} failed: {}\n", counted(std::size_t(shards), "shard"),
               (folder / "parallel" / "errors.txt").string());
  if (stop && *stop) return {false, kInterrupted};
  return {true, kOk};
}

}  // namespace

RemoteEnd compare_on(const CompareOptions& options, const StudyPlan& plan, const fs::path& folder,
                     StudyPlatforms platforms, const std::atomic<bool>* stop) {
  const std::string engine = options.on.substr(0, options.on.find(':'));
  const std::string where = engine.size() < options.on.size() ? options.on.substr(engine.size() + 1) : "";
  RemoteEnd end;
  if (engine == "slurm")
    end = submit_to_slurm(options, plan, folder, platforms, stop, where);
  else if (engine == "ssh" && !where.empty())
    end = run_over_ssh(options, plan, folder, platforms, stop, where);
  else
    throw UsageError("--on " + options.on + ": must be slurm, slurm:PARTITION or ssh:HOST,HOST");
  if (!end.all_on_record) return end;
  const auto journal = on_record(plan, folder, platforms);
  const std::size_t left = prints_to_do(plan, *journal, {}).size();
  if (left == 0) return end;
  fmt::print(stderr, "{} missing; the same command submits them again\n",
             left == 1 ? "1 print is" : std::to_string(left) + " prints are");
  if (journal->of_other_platforms() > 0 && platforms == StudyPlatforms::kThis)
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
