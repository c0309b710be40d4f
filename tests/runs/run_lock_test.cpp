// The lock of a run folder: one writer or still readers, named holders, nothing left by the dead.
#include "runs/folder/run_lock.h"

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "cli/export_command.h"
#include "cli/log_command.h"
#include "cli/print_command.h"
#include "cli/replay_command.h"
#include "cli/report_command.h"
#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "page/watched_run.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/folder/list.h"
#include "runs/folder/pack.h"
#include "runs/folder/running.h"
#include "runs/folder/seal_check.h"
#include "runs/folder/trial_files.h"
#include "tests/support/long_cases.h"
#include "tests/support/temp_folder.h"
#include "tests/support/tiny_print.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using runs::RunLock;
using runs::RunUse;

constexpr RunUse kUses[] = {RunUse::kPrint,  RunUse::kWrite, RunUse::kRead,
                            RunUse::kReport, RunUse::kNote,  RunUse::kRemove};

Experiment part(std::uint64_t seed) {
  Experiment e = test::tiny_print("lock");
  e.plant.seed = seed;
  return e;
}

// A run whose print was stopped, or went to its end.
fs::path printed(const fs::path& root, std::uint64_t seed, bool stopped) {
  const Experiment e = part(seed);
  const runs::RunFolder run = runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  if (stopped) o.later = {{12.0, {new_order_id(), OperatorVerb::kStop, {}, {}}}};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == (stopped ? kSafetyStop : kOk));
  return run.path();
}

// Runs `act` in a process of its own after a delay. Its status is that of act, 2 where it was refused.
class Child {
 public:
  Child(int delay_us, const std::function<void()>& act) : pid_(::fork()) {
    if (pid_ != 0) return;
    ::usleep(useconds_t(delay_us));
    ::freopen("/dev/null", "w", stdout);
    ::freopen("/dev/null", "w", stderr);
    int status = 0;
    try {
      act();
    } catch (const UsageError& e) {
      const std::string why = e.what();
      const bool named =
          why.find("pid ") != std::string::npos || why.find("is no run folder") != std::string::npos;
      status = named ? kUsage : 99;
    } catch (const std::exception&) {
      status = 98;
    }
    ::_exit(status);
  }
  pid_t pid() const { return pid_; }
  void kill() const { ::kill(pid_, SIGKILL); }
  int wait() const {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_;
};

std::vector<fs::path> trial_files(const fs::path& run) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::recursive_directory_iterator(run))
    if (runs::is_trial_file(entry.path().string())) found.push_back(entry.path());
  return found;
}

TEST_CASE("each use of a run folder keeps out those that would disturb it, and a second comer is told who") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), 1, false);
  // Rows: held; columns: asked for, both in the order of kUses.
  const std::string kept_out[] = {"xxxx.x", "xxxx.x", "xx...x", "xx.x.x", "....xx", "xxxxxx"};
  for (std::size_t held = 0; held < std::size(kUses); ++held) {
    const Child holder(0, [&] {
      const RunLock lock(run, kUses[held]);
      ::pause();
    });
    const auto there = [&] {
      const auto found = runs::holder_against(run, RunUse::kRemove);
      return found && found->pid == holder.pid();
    };
    while (!there()) ::usleep(1000);
    for (std::size_t asked = 0; asked < std::size(kUses); ++asked) {
      INFO("held " << held << ", asked " << asked);
      const auto against = runs::holder_against(run, kUses[asked]);
      CHECK(against.has_value() == (kept_out[held][asked] == 'x'));
      if (kUses[asked] == RunUse::kNote || kept_out[held][asked] != 'x') continue;
      CHECK_THROWS_WITH(RunLock(run, kUses[asked]), Contains("pid " + std::to_string(holder.pid())) &&
                                                        Contains(" since ") && Contains(run.string()));
    }
    CHECK((runs::printing_process(run) == std::optional<pid_t>(holder.pid())) ==
          (kUses[held] == RunUse::kPrint));
    holder.kill();
    holder.wait();
    CHECK_NOTHROW(RunLock(run, RunUse::kRemove));
  }
}

TEST_CASE("the lock file is its owner's alone, and the last holder removes it") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), 2, false), file = run / "lock";
  {
    const RunLock first(run, RunUse::kRead), second(run, RunUse::kRead), note(run, RunUse::kNote);
    struct stat s {};
    REQUIRE(::stat(file.c_str(), &s) == 0);
    CHECK((s.st_mode & 0777) == 0600);
  }
  CHECK_FALSE(fs::exists(file));
  fs::create_symlink(root.file("else", "mine"), file);
  CHECK_THROWS_WITH(RunLock(run, RunUse::kWrite), Contains("is no regular file"));
  CHECK(read_file(root.path() / "else") == "mine");
}

TEST_CASE(
    "many readers and writers that come and go at once never hold a run together, and none is left out") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), 3, false);
  const fs::path file = root.file("count", "0");
  std::vector<Child> children;
  for (int n = 0; n < 8; ++n)
    children.emplace_back(0, [&] {
      for (int done = 0; done < 25;) try {
          const RunLock lock(run, RunUse::kWrite);
          const int before = std::stoi(read_file(file));
          ::usleep(200);
          write_file_atomically(file, std::to_string(before + 1));
          ++done;
        } catch (const UsageError&) {
        }
    });
  for (const Child& child : children) CHECK(child.wait() == 0);
  CHECK(read_file(file) == "200");
}

TEST_CASE(
    "packing or expanding that is killed at any moment leaves a run that audits clean, without trial files") {
  const test::TempFolder root;
  const fs::path original = printed(root.path(), 4, true);
  for (const std::size_t n : test::long_cases(200, 12)) {
    RandomStream random(n, Purpose::kTest);
    const fs::path run = root.path() / ("copy-" + std::to_string(n));
    fs::copy(original, run, fs::copy_options::recursive);
    const bool expands = n % 2;
    if (expands) runs::pack_run(run);
    const Child child(0, [&] { expands ? runs::expand_run(run) : runs::pack_run(run); });
    ::usleep(useconds_t(random.below(30'000)));
    child.kill();
    child.wait();
    INFO("case " << n);
    {
      const RunLock look(run, RunUse::kRead);
      CHECK(trial_files(run).empty());
    }
    CHECK(runs::check_seals(run).whole());
    CHECK(replay::audit_run(run).clean());
    PrintOptions again;
    again.resume = run.string();
    again.bus = "in-process";
    if (n % 5 == 0) {
      CHECK(run_print(full_product(), again) == kOk);
      CHECK(replay::audit_run(run).clean());
    }
    fs::remove_all(run);
  }
}

TEST_CASE("what a kill left under a trial name neither alters the sealed run nor stays") {
  const test::TempFolder root;
  const fs::path run = printed(root.path(), 5, false);
  for (const char* name :
       {"nodes/stage.wal.packed", "nodes/stage.wal.part", "log.lcm.repairing", "world/state.new"})
    write_file_atomically(run / name, "half");
  CHECK(runs::check_seals(run).whole());
  { const RunLock look(run, RunUse::kRead); }
  CHECK(trial_files(run).empty());
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("a removal that is killed leaves the run whole or gone, and the next one finishes it") {
  const test::TempFolder root;
  const fs::path original = printed(root.path(), 6, false);
  for (const std::size_t n : test::long_cases(200, 8)) {
    RandomStream random(n, Purpose::kTest);
    const fs::path place = root.path() / "runs", run = place / "a";
    fs::create_directories(place);
    fs::copy(original, run, fs::copy_options::recursive);
    const runs::RunEntry entry = runs::run_entry(run);
    const Child child(0, [&] { runs::remove_run(entry); });
    ::usleep(useconds_t(random.below(5'000)));
    child.kill();
    child.wait();
    const std::size_t left = runs::list_runs(place).size();
    CHECK(left == (fs::exists(run) ? 1 : 0));
    if (left) CHECK(replay::audit_run(run).clean());
    runs::finish_removals(place);
    if (!left) CHECK(fs::is_empty(place));
    fs::remove_all(place);
  }
}

struct RivalCommand {
  const char* name;
  std::function<void(const fs::path& run)> act;
};

const std::vector<RivalCommand>& rival_commands() {
  static const std::vector<RivalCommand> all = {
      {"print --resume",
       [](const fs::path& run) {
         PrintOptions o;
         o.resume = run.string();
         o.bus = "in-process";
         run_print(full_product(), o);
       }},
      {"runs pack", [](const fs::path& run) { runs::pack_run(run); }},
      {"runs expand", [](const fs::path& run) { runs::expand_run(run); }},
      {"runs clean",
       [](const fs::path& run) {
         if (fs::exists(run)) runs::remove_run(runs::run_entry(run));
       }},
      {"log repair",
       [](const fs::path& run) {
         LogOptions o;
         o.action = LogAction::kRepair;
         o.file = (run / "log.lcm").string();
         run_log(o);
       }},
      {"replay",
       [](const fs::path& run) {
         ReplayCommandOptions o;
         o.run = run.string();
         o.threads = 1;
         if (!replay_verdict(full_product(), o).identical()) ::_exit(97);
       }},
      {"audit",
       [](const fs::path& run) {
         const runs::RunLock still(run, runs::RunUse::kRead);
         if (!replay::audit_run(run).clean()) ::_exit(97);
       }},
      {"report",
       [](const fs::path& run) {
         ReportOptions o;
         o.runs = {run.string()};
         o.output = (run / "report.html").string();
         o.no_replay = true;
         write_report(full_product(), o);
       }},
      {"export",
       [](const fs::path& run) {
         ExportOptions o;
         o.runs = {run.string()};
         o.output = (run.parent_path() / "x.mcap").string();
         run_export(o);
       }},
      {"a note", [](const fs::path& run) { runs::add_notes(run, {}); }},
  };
  return all;
}

TEST_CASE("no two commands at once on one run lose anything of it: each pair, with random delays") {
  const test::TempFolder root;
  const fs::path original = printed(root.path(), 7, true);
  const std::size_t pairs = rival_commands().size() * rival_commands().size();
  for (const std::size_t n : test::long_cases(pairs * 20, pairs)) {
    const RivalCommand &first = rival_commands()[n % pairs / rival_commands().size()],
                       &second = rival_commands()[n % rival_commands().size()];
    RandomStream random(n, Purpose::kTest);
    const fs::path run = root.path() / ("pair-" + std::to_string(n));
    fs::copy(original, run, fs::copy_options::recursive);
    if (random.below(2)) runs::pack_run(run);
    const Child a(0, [&] { first.act(run); }), b(int(random.below(20'000)), [&] { second.act(run); });
    const int ends[] = {a.wait(), b.wait()};
    INFO(first.name << " and " << second.name << ", case " << n << ": " << ends[0] << ", " << ends[1]);
    const bool removes = std::string(first.name) == "runs clean" || std::string(second.name) == "runs clean";
    for (const int end : ends) CHECK((end == 0 || end == kUsage || (removes && !fs::exists(run))));
    if (fs::exists(run)) {
      const RunLock look(run, RunUse::kRead);
      CHECK(trial_files(run).empty());
      CHECK(runs::check_seals(run).whole());
      CHECK(replay::audit_run(run).clean());
    } else {
      CHECK(removes);
    }
    fs::remove_all(run);
  }
}

}  // namespace
}  // namespace firn
