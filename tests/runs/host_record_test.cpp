// The records of a run's other computers: written, read back, and said where they are not all here.
#include "runs/folder/host_record.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <stdexcept>
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

TEST_CASE(
    "a stranger's record of a host names no file outside, no option of ssh and no process that is none") {
  const auto refused = [](const std::string& file, HostRecord r) {
    const test::TempFolder dir;
    r.complete = false;
    write_host_record(dir.path(), kBench);
    std::filesystem::remove(dir.path() / "hosts" / "bench.json");
    std::string nodes;
    for (const std::string& node : r.nodes) nodes += (nodes.empty() ? "\"" : ", \"") + node + "\"";
    dir.file("hosts/" + file, "{\"name\": \"" + r.name + "\", \"address\": \"" + r.address +
                                  "\", \"program\": \"" + r.program + "\", \"nodes\": [" + nodes +
                                  "], \"complete\": false}");
    try {
      host_records(dir.path());
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("taken");
  };
  HostRecord r = kBench;
  CHECK(refused("bench.json", r) == "taken");
  CHECK(refused("attic.json", r).find("name 'bench'") != std::string::npos);
  r.name = "../../bench";
  CHECK(refused("bench.json", r).find("name '../../bench'") != std::string::npos);
  r = kBench;
  r.address = "-oProxyCommand=touch /tmp/x";
  CHECK(refused("bench.json", r).find("address '-oProxy") != std::string::npos);
  r = kBench;
  r.program = "-x";
  CHECK(refused("bench.json", r).find("program '-x'") != std::string::npos);
  r = kBench;
  r.nodes = {"../../../home/me/.ssh/config"};
  CHECK(refused("bench.json", r).find("node '../") != std::string::npos);
}
