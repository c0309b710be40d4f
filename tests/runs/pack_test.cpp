// Packed run folders: every reader reads them, seals hold, a resume goes on.
#include "runs/folder/pack.h"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "cli/replay_command.h"
#include "core/grid/random.h"
#include "files/digest.h"
#include "files/exit_codes.h"
#include "files/record/packed.h"
#include "files/record/record_file.h"
#include "files/text_file.h"
#include "files/usage_error.h"
#include "print/labs/full_product.h"
#include "print/simulated/lab_run.h"
#include "replay/audit_run.h"
#include "runs/folder/list.h"
#include "runs/folder/log_repair.h"
#include "runs/folder/run_lock.h"
#include "runs/folder/seal.h"
#include "runs/folder/seal_check.h"
#include "tests/support/peak_memory.h"
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
  CHECK(replay_verdict(full_product(), o).identical());
  CHECK(replay::audit_run(run).clean());
  CHECK(runs::check_seals(run).whole());
}

TEST_CASE("a packed run takes a fifth of its room, reads as before, and unpacks to the same bytes") {
  const test::TempFolder place;
  const Experiment e = part(40, 3);
  const runs::RunFolder run =
      runs::RunFolder::create(place.path(), e, make_inputs(full_product(), e, ""), {"test"});
  REQUIRE(run_in_lab(full_product(), run, {}).result.status == kOk);
  const auto plain = contents(run.path());
  const std::uint64_t before = runs::folder_bytes(run.path());
  const runs::PackReport report = runs::pack_run(run.path());
  CHECK(report.after < report.before);
  INFO(before << " bytes, packed " << runs::folder_bytes(run.path()));
  CHECK(runs::folder_bytes(run.path()) * 5 <= before);
  CHECK(record::is_packed(run.path() / "log.lcm"));
  check_unpacked(run.path());
  CHECK(runs::pack_run(run.path()).after == report.after);  // nothing is left to do
  runs::expand_run(run.path());
  CHECK(contents(run.path()) == plain);
}

// Both are larger than the 64 MiB window of the compressor, of which packing holds two: it unpacks what it
// wrote.
TEST_CASE("packing, digests and expansion of records hold the same memory at 80 and 160 MB") {
  constexpr double kMiB = 1 << 20;
  struct Peaks {
    std::size_t pack, digest, expand;
  };
  std::vector<Peaks> peaks;
  std::vector<std::uint64_t> packed;
  for (const std::size_t megabytes : {80, 160}) {
    const test::TempFolder run;
    fs::create_directory(run.path() / "nodes");
    const fs::path file = run.path() / "nodes" / "stage.wal";
    {
      RandomStream random(3, Purpose::kTest);
      record::RecordWriter writer(file, record::RecordWriter::Mode::kCreate, 1 << 20);
      std::vector<std::byte> payload(1024);
      for (std::size_t n = 0; n < megabytes * 1000; ++n) {
        for (int k = 0; k < 100; ++k) payload[random.below(1024)] = std::byte(random.below(256));
        writer.append(2, payload);
      }
      writer.close();
    }
    const std::string plain = runs::digest_file(file, {}, false).sha256;
    Peaks p;
    p.pack = test::peak_of([&] { runs::pack_records(run.path()); });
    REQUIRE(record::is_packed(file));
    packed.push_back(fs::file_size(file));
    p.digest = test::peak_of([&] { runs::digest_file(file, {}, false); });
    CHECK(runs::digest_file(file, {}, false).sha256 == plain);
    p.expand = test::peak_of([&] { runs::expand_records(run.path()); });
    CHECK_FALSE(record::is_packed(file));
    CHECK(runs::digest_file(file, {}, false).sha256 == plain);
    CHECK(double(p.pack) < 192 * kMiB);
    CHECK(double(p.digest) < 128 * kMiB);
    CHECK(double(p.expand) < 128 * kMiB);
    peaks.push_back(p);
  }
  CHECK(double(peaks[1].pack) < double(peaks[0].pack) + 16 * kMiB);
  CHECK(double(peaks[1].digest) < double(peaks[0].digest) + 16 * kMiB);
  CHECK(double(peaks[1].expand) < double(peaks[0].expand) + 16 * kMiB);
  CHECK(std::log2(double(packed[1]) / double(packed[0])) == Approx(1.0).margin(0.05));
}

TEST_CASE("a packed print that was stopped goes on, and the repair of a packed log leaves a whole run") {
  const test::TempFolder place;
  const Experiment e = part(9, 4);
  const runs::RunFolder run =
      runs::RunFolder::create(place.path(), e, make_inputs(full_product(), e, ""), {"test"});
  LabRunOptions o;
  o.later = {{12.0, {new_order_id(), OperatorVerb::kStop, {}, {}}}};
  REQUIRE(run_in_lab(full_product(), run, o).result.status == kSafetyStop);
  runs::pack_run(run.path());
  check_unpacked(run.path());
  CHECK_FALSE(runs::repair_from_write_ahead(run.path() / "log.lcm", run.path() / "nodes").rewritten);
  check_unpacked(run.path());
  runs::pack_run(run.path());
  LabRunOptions again;
  again.resume = true;
  CHECK(run_in_lab(full_product(), run, again).result.status == kOk);
  check_unpacked(run.path());
}

TEST_CASE("a run that somebody prints is neither packed nor replayed, and the list names the process") {
  const test::TempFolder place;
  const Experiment e = part(9, 5);
  const runs::RunFolder run =
      runs::RunFolder::create(place.path(), e, make_inputs(full_product(), e, ""), {"test"});
  REQUIRE(run_in_lab(full_product(), run, {}).result.status == kOk);
  const std::string running = "is running (pid " + std::to_string(::getpid()) + ")";
  {
    const runs::RunLock held(run.path(), runs::RunUse::kPrint);
    CHECK_THROWS_WITH(runs::pack_run(run.path()), Catch::Contains(running));
    ReplayCommandOptions o;
    o.run = run.path().string();
    CHECK_THROWS_WITH(replay_verdict(full_product(), o), Catch::Contains(running));
    const auto runs = runs::list_runs(place.path());
    REQUIRE(runs.size() == 1);
    CHECK(runs[0].running);
    CHECK(runs[0].outcome == "running (pid " + std::to_string(::getpid()) + ")");
  }
  const auto runs = runs::list_runs(place.path());
  REQUIRE(runs.size() == 1);
  CHECK(runs[0].outcome == "finished");
  CHECK(runs[0].bytes > 1000);
  CHECK_THROWS_AS(runs::list_runs(place.path() / "nowhere"), UsageError);
}

}  // namespace
}  // namespace firn
