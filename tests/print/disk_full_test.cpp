// The disk refuses writes of a print in one process, or the process is killed: the print stops by name,
// and a resume finishes it.
#include <catch2/catch.hpp>

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "cli/replay_command.h"
#include "core/grid/random.h"
#include "files/exit_codes.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "replay/print_verdict.h"
#include "runs/folder/folder_watch.h"
#include "tests/print/disk_faults.h"
#include "tests/support/long_cases.h"
#include "tests/support/tiny_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

Experiment tiny(std::uint64_t seed) {
  Experiment e = tiny_print("disk");
  e.plant.seed = seed;
  return e;
}

struct Runs {
  Runs() : root(fs::temp_directory_path() / ("firn-disk-" + std::to_string(::getpid()))) {
    fs::create_directories(root);
  }
  ~Runs() { fs::remove_all(root); }
  runs::RunFolder create(const Experiment& e) const {
    return runs::RunFolder::create(root, e, make_inputs(full_product(), e, ""), {"test"});
  }
  fs::path root;
};

void check_whole(const fs::path& path) {
  ReplayCommandOptions r;
  r.run = path.string();
  const replay::RunVerdict verdict = replay_verdict(full_product(), r);
  INFO(replay::to_text(verdict));
  CHECK(verdict.identical());
  const replay::AuditVerdict audit = replay::audit_run(path);
  INFO(to_text(audit));
  CHECK(audit.clean());
  CHECK(audit.finished);
}

LabRunReport print(const runs::RunFolder& run, bool resume) {
  LabRunOptions o;
  o.resume = resume;
  return run_in_lab(full_product(), run, o);
}

TEST_CASE("each write of a print in one process fails in turn, by name, and a resume finishes the print") {
  const Runs runs;
  const Experiment e = tiny(3);
  std::uint64_t writes = 0, resume_writes = 0;
  {
    const runs::RunFolder run = runs.create(e);
    const DiskFaults counted(run.path(), DiskFaults::kNever);
    REQUIRE(print(run, false).result.status == kOk);
    writes = counted.calls();
  }
  REQUIRE(writes > 30);
  for (const std::size_t before : long_cases(writes, 12))
    for (const bool stays : {false, true}) {
      const std::uint64_t n = before + 1;
      CAPTURE(n, writes, stays);
      RandomStream random(5, Purpose::kTest, std::uint32_t(n), stays);
      const runs::RunFolder run = runs.create(e);
      LabRunReport r;
      {
        const DiskFaults fault(run.path(), n, stays);
        r = print(run, false);
      }
      CHECK(r.result.status == kSafetyStop);
      CHECK_THAT(r.result.reason, Contains("No space left on device") && Contains(run.path().string()));
      CHECK_FALSE(run.result());
      if (r.result.layers > 0) {
        const replay::AuditVerdict audit = replay::audit_run(run.path());
        INFO(to_text(audit));
        CHECK(audit.clean());
      }
      {  // the resume finds a full disk too, somewhere
        const DiskFaults fault(run.path(), 1 + random.below(std::uint32_t(writes)), stays);
        r = print(run, true);
        resume_writes += fault.calls();
      }
      for (int more = 0; r.result.status != kOk && more < 2; ++more) {
        CAPTURE(r.result.reason);
        CHECK(r.result.status == kSafetyStop);
        r = print(run, true);
      }
      INFO(r.result.reason);
      CHECK(r.result.status == kOk);
      check_whole(run.path());
      fs::remove_all(run.path());
    }
  CHECK(resume_writes > 0);
}

TEST_CASE("each of the last writes of a print fails in turn: no result stays without the seal of its end") {
  const Runs runs;
  std::uint64_t writes = 0;
  {
    const runs::RunFolder run = runs.create(tiny(3));
    const DiskFaults counted(run.path(), DiskFaults::kNever);
    REQUIRE(print(run, false).result.status == kOk);
    writes = counted.calls();
  }
  for (std::uint64_t n = writes - 24; n <= writes; ++n) {
    CAPTURE(n, writes);
    const runs::RunFolder run = runs.create(tiny(3));
    {
      const DiskFaults fault(run.path(), n, false);
      CHECK(print(run, false).result.status == kSafetyStop);
    }
    CHECK_FALSE(run.result());
    CHECK(print(run, true).result.status == kOk);
    check_whole(run.path());
    fs::remove_all(run.path());
  }
}

TEST_CASE("each of the first writes of a resume fails in turn, by name: those of its seal too") {
  const Runs runs;
  const runs::RunFolder run = runs.create(tiny(3));
  {
    const DiskFaults fault(run.path(), 300, true);
    REQUIRE(print(run, false).result.status == kSafetyStop);
  }
  for (std::uint64_t call = 1; call <= 40; ++call) {
    CAPTURE(call);
    const DiskFaults fault(run.path(), call, true);
    const LabRunReport r = print(run, true);
    CHECK(r.result.status == kSafetyStop);
    CHECK_THAT(r.result.reason, Contains("No space left on device") && Contains(run.path().string()));
  }
  CHECK(print(run, true).result.status == kOk);
  check_whole(run.path());
}

TEST_CASE("a run folder that is moved or deleted during a print in one process ends the print by name") {
  const Runs runs;
  for (const bool deleted : {false, true}) {
    const runs::RunFolder run = runs.create(tiny(4));
    const fs::path moved = runs.root / "elsewhere";
    LabRunOptions o;
    o.progress = [&](const layer_metrics_t& m) {
      if (m.layer != 1 || !fs::exists(run.path())) return;
      deleted ? void(fs::remove_all(run.path())) : fs::rename(run.path(), moved);
    };
    const LabRunReport r = run_in_lab(full_product(), run, o);
    CHECK(r.result.status == kSafetyStop);
    CHECK_THAT(r.result.reason, Contains("the run folder " + run.path().string() +
                                         (deleted ? " was deleted" : " was moved to ")));
    CHECK(r.folder == (deleted ? fs::path() : fs::canonical(moved)));
    if (deleted) continue;
    CHECK(print(runs::RunFolder::open(moved), true).result.status == kOk);
    check_whole(moved);
  }
}

TEST_CASE("a print in one process that is killed at any moment goes on from its last layer") {
  const Runs runs;
  int all = 0;
  for (const std::size_t n : long_cases(100, 8)) {
    RandomStream random(8, Purpose::kKill, std::uint32_t(n));
    const runs::RunFolder run = runs.create(tiny(20 + n));
    int kills = 0;
    for (bool killed = true; killed;) {
      const std::uint32_t looks = 1 + random.below(15);
      const pid_t child = ::fork();
      if (child == 0) {
        LabRunOptions o;
        o.resume = kills > 0;
        std::uint32_t seen = 0;
        o.interrupted = [&] {
          if (++seen == looks && kills < 3) ::_exit(9);  // no buffer is written any more
          return false;
        };
        ::_exit(run_in_lab(full_product(), run, o).result.status);
      }
      int status = 0;
      ::waitpid(child, &status, 0);
      REQUIRE(WIFEXITED(status));
      killed = WEXITSTATUS(status) == 9;
      kills += killed;
      CHECK((killed || WEXITSTATUS(status) == kOk));
    }
    CAPTURE(n, kills);
    all += kills;
    check_whole(run.path());
  }
  CHECK(all > 8);
}

TEST_CASE("a print in one process that is interrupted says so, and its resume goes on") {
  const Runs runs;
  const runs::RunFolder run = runs.create(tiny(6));
  LabRunOptions o;
  int layers = 0;
  o.progress = [&](const layer_metrics_t& m) { layers = m.layer; };
  o.interrupted = [&] { return layers >= 2; };
  const LabRunReport r = run_in_lab(full_product(), run, o);
  CHECK(r.result.status == kInterrupted);
  CHECK(r.result.outcome == "interrupted");
  CHECK_FALSE(run.result());
  CHECK(print(run, true).result.status == kOk);
  check_whole(run.path());
}

}  // namespace
}  // namespace firn::test
