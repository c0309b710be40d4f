// The records of a run's other computers: written, read back, and said where they are not all here.
#include "runs/folder/host_record.h"

#include <catch2/catch.hpp>

#include <string>

#include "tests/support/temp_folder.h"

using namespace firn;
using namespace firn::runs;

namespace {

const HostRecord kBench{"bench", "me@bench-pc", "/opt/firn/bin/firn", {"stage", "jet"}, false};

}  // namespace

TEST_CASE("a run on one computer has no hosts and is not incomplete") {
  const test::TempFolder dir;
  CHECK(host_records(dir.path()).empty());
  CHECK(incomplete_text(dir.path()).empty());
}

TEST_CASE("a host whose records are not all here is named with its processes until they are") {
  const test::TempFolder dir;
  write_host_record(dir.path(), kBench);
  write_host_record(dir.path(), {"attic", "attic", "firn", {"lamp"}, true});
  CHECK(incomplete_text(dir.path()) == "incomplete: host bench (stage, jet)");
  const auto records = host_records(dir.path());
  REQUIRE(records.size() == 2);
  CHECK(records[1].address == kBench.address);
  CHECK(records[1].program == kBench.program);
  CHECK(records[1].nodes == kBench.nodes);
  HostRecord whole = kBench;
  whole.complete = true;
  write_host_record(dir.path(), whole);
  CHECK(incomplete_text(dir.path()).empty());
}

TEST_CASE("a damaged record of a host is named by its file") {
  const test::TempFolder dir;
  write_host_record(dir.path(), kBench);
  dir.file("hosts/bench.json", "{\"name\": 3}");
  CHECK_THROWS_WITH(host_records(dir.path()), Catch::Contains("bench.json"));
}
