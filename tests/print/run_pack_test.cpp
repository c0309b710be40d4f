// Packed run folders: every reader reads them, seals hold, a resume goes on.
#include "print/folder/run_pack.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <map>

#include "cli/audit_command.h"
#include "cli/replay_command.h"
#include "files/digest.h"
#include "files/record/packed.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/exit_codes.h"
#include "print/folder/lab_lock.h"
#include "print/folder/log_repair.h"
#include "print/folder/run_list.h"
#include "print/folder/seal_check.h"
#include "print/labs/print_labs.h"
#include "print/simulated/lab_run.h"
#include "tests/support/temp_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

Experiment part(int cells, std::uint64_t seed) {
  Experiment e;
  e.run.name = "pack";
  e.grid = {cells, cells, 0.263256, 0.263256, 0.0, 0.0};
  e.part.shape.kind = "cuboid";
  e.part.shape.width_mm = e.part.shape.depth_mm = 0.7 * cells * 0.263256;
  e.part.shape.height_mm = 0.04;
  e.plant.seed = seed;
  return e;
}

std::map<std::string, std::string> contents(const fs::path& run) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(run))
    if (entry.symlink_status().type() == fs::file_type::regular && entry.path().filename() != "lock")
      all[entry.path().lexically_relative(run).string()] = read_file(entry.path());
  return all;
}

void check_unpacked(const fs::path& run) {
  ReplayCommandOptions o;
  o.run = run.string();
  CHECK(replay_verdict(o).identical());
  CHECK(audit_verdict(run).clean());
  CHECK(check_seals(run).whole());
}

TEST_CASE("a packed run takes a fifth of its room, reads as before, and unpacks to the same bytes") {
  const test::TempFolder place;
  const Experiment e = part(40, 3);
  const RunFolder run = RunFolder::create(place.path(), e, make_inputs(e, ""), {"test"});
  REQUIRE(run_in_lab(run, {}).result.status == kOk);
  const auto plain = contents(run.path());
  const std::uint64_t before = folder_bytes(run.path());
  const PackReport report = pack_run(run.path());
  CHECK(report.after < report.before);
  INFO(before << " bytes, packed " << folder_bytes(run.path()));
  CHECK(folder_bytes(run.path()) * 5 <= before);
  CHECK(logfile::is_packed(run.path() / "log.lcm"));
  check_unpacked(run.path());
  CHECK(pack_run(run.path()).after == report.after);  // nothing is left to do
  expand_run(run.path());
  CHECK(contents(run.path()) == plain);
}

TEST_CASE("a packed print that was stopped goes on, and the repair of a packed log leaves a whole run") {
  const test::TempFolder place;
  const Experiment e = part(9, 4);
  const RunFolder run = RunFolder::create(place.path(), e, make_inputs(e, ""), {"test"});
  LabRunOptions o;
  o.later = {{12.0, {new_order_id(), OperatorVerb::kStop, {}, {}}}};
  REQUIRE(run_in_lab(run, o).result.status == kSafetyStop);
  pack_run(run.path());
  check_unpacked(run.path());
  CHECK_FALSE(repair_from_write_ahead(run.path() / "log.lcm", run.path() / "nodes").rewritten);
  check_unpacked(run.path());
  pack_run(run.path());
  LabRunOptions again;
  again.resume = true;
  CHECK(run_in_lab(run, again).result.status == kOk);
  check_unpacked(run.path());
}

TEST_CASE("a run that somebody prints is neither packed nor replayed, and the list names the process") {
  const test::TempFolder place;
  const Experiment e = part(9, 5);
  const RunFolder run = RunFolder::create(place.path(), e, make_inputs(e, ""), {"test"});
  REQUIRE(run_in_lab(run, {}).result.status == kOk);
  const std::string running = "is running (pid " + std::to_string(::getpid()) + ")";
  {
    const LabLock held(run, e, "", LabLock::Heirs::kNobody);
    CHECK_THROWS_WITH(pack_run(run.path()), Catch::Contains(running));
    ReplayCommandOptions o;
    o.run = run.path().string();
    CHECK_THROWS_WITH(replay_verdict(o), Catch::Contains(running));
    const auto runs = list_runs(place.path());
    REQUIRE(runs.size() == 1);
    CHECK(runs[0].running);
    CHECK(runs[0].outcome == "running (pid " + std::to_string(::getpid()) + ")");
  }
  const auto runs = list_runs(place.path());
  REQUIRE(runs.size() == 1);
  CHECK(runs[0].outcome == "finished");
  CHECK(runs[0].bytes > 1000);
  CHECK(mentions(runs[0], "CUBOID"));
  CHECK_FALSE(mentions(runs[0], "helical"));
  CHECK_THROWS_AS(list_runs(place.path() / "nowhere"), UsageError);
}

}  // namespace
}  // namespace firn
