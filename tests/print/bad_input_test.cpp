// Input of a careless or hostile user, beyond the experiment's keys: each is refused by name, with exit code
// 2, and nothing is left behind.
#include <fmt/core.h>
#include <catch2/catch.hpp>
#include <cmath>

#include "cli/log_command.h"
#include "cli/print_command.h"
#include "config/include.h"
#include "files/usage_error.h"
#include "print/inputs/check_print.h"
#include "print/labs/full_product.h"
#include "print/process/bus_port.h"
#include "runs/folder/run_folder.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using namespace firn::test;
using Catch::Matchers::Contains;

TEST_CASE("A bus that several processes cannot share is refused before a run folder is made") {
  for (const char* good :
       {"", "in-process", "udpm://239.255.76.67:7667", "udpm://224.0.0.1:1?ttl=0&recv_buf_size=4194304"})
    CHECK_NOTHROW(check_bus(good));
  const std::pair<const char*, const char*> bad[] = {
      {"garbage", "no bus of several processes"},
      {"memq://", "no bus of several processes"},
      {"udpm://", "no port"},
      {"udpm://239.255.76.67", "no port"},
      {"udpm://239.255.76.67?a:7", "no port"},
      {"udpm://1.2.3:7667", "1.2.3 is no multicast address"},
      {"udpm://10.0.0.1:7667", "10.0.0.1 is no multicast address"},
      {"udpm://239.255.76.67:99999", "[1, 65535]"},
      {"udpm://239.255.76.67:0", "[1, 65535]"},
      {"udpm://239.255.76.67:7x", "[1, 65535]"}};
  const Scratch scratch("bad-bus");
  for (const auto& [url, what] : bad) {
    CAPTURE(url);
    PrintOptions o;
    o.bus = url;
    o.runs = (scratch / "runs").string();
    CHECK_THROWS_WITH(print_experiment(full_product(), Experiment{}, {}, o),
                      Contains("--bus " + std::string(url)) && Contains(what));
    CHECK_THROWS_AS(check_bus(url), UsageError);
  }
  CHECK_FALSE(std::filesystem::exists(scratch / "runs"));
}

TEST_CASE(
    "A grid too fine for the simulated droplet, or too large for the bus, is refused before a run folder is "
    "made") {
  Experiment fine;
  fine.grid.pitch_x_mm = fine.grid.pitch_y_mm = 0.02;
  CHECK_THROWS_WITH(check_print(fine, "in-process"),
                    Contains("droplet.cap_radius_mm") && Contains("is outside"));
  CHECK_THROWS_AS(check_print(fine, "in-process"), UsageError);
  Experiment large;
  large.grid.nx = large.grid.ny = 4096;
  CHECK_THROWS_WITH(check_print(large, ""), Contains("grid.nx = 4096") && Contains("67108864"));
  CHECK_THROWS_AS(check_print(large, ""), UsageError);
  CHECK_NOTHROW(check_print(large, "in-process"));
}

TEST_CASE("A place where no run folder can be made is a usage error that says what to do") {
  const Scratch scratch("bad-runs");
  write_file(scratch / "file", std::vector<std::byte>(3));
  for (const auto& root : {scratch / "file" / "runs", scratch / std::string(300, 'x')}) {
    CHECK_THROWS_WITH(runs::RunFolder::create(root, Experiment{}, {}, {}),
                      Contains(root.string()) && Contains("--runs"));
    CHECK_THROWS_AS(runs::RunFolder::create(root, Experiment{}, {}, {}), UsageError);
  }
}

TEST_CASE(
    "A live print faster than the profiler's rows can be asked for is refused by name before a run folder is "
    "made") {
  const Scratch scratch("fast-rows");
  PrintOptions o;
  o.experiment = std::string(FIRN_SOURCE_DIR) + "/experiments/cylinder.toml";
  o.runs = (scratch / "runs").string();
  // 0.263256 mm a row at 15 mm/s: 17.55 ms, which leaves 5 ms of wall time up to a speedup of 3.51.
  for (const double speedup : {3.6, 10.0}) {
    CAPTURE(speedup);
    o.speedup = speedup;
    CHECK_THROWS_WITH(
        run_print(full_product(), o),
        Contains(fmt::format("{:.2f} ms of wall time", 17.5504 / speedup)) && Contains("laser_profiler") &&
            Contains("below 5 ms") && Contains("process.scan_speed_mm_s = 15") &&
            Contains(fmt::format("to at most {:.2f}", std::floor(5.26512 / speedup * 1000.0) / 100.0)) &&
            Contains("--speedup to at most 3.51") && Contains("--bus in-process"));
    CHECK_THROWS_AS(run_print(full_product(), o), UsageError);
  }
  CHECK_FALSE(std::filesystem::exists(scratch / "runs"));
  const auto checked = [&](const char* file, std::vector<std::string> overrides, const char* bus) {
    check_print(load_experiment(std::string(FIRN_SOURCE_DIR) + "/experiments/" + file, overrides), bus);
  };
  // The values that the message proposes are accepted, and so are a print at the clock's own speed, one in
  // process and one without a profiler.
  CHECK_NOTHROW(checked("cylinder.toml", {"run.time_scale=3.51"}, ""));
  CHECK_NOTHROW(checked("cylinder.toml", {"run.time_scale=10", "process.scan_speed_mm_s=5.26"}, ""));
  CHECK_THROWS_AS(checked("cylinder.toml", {"run.time_scale=10", "process.scan_speed_mm_s=5.27"}, ""),
                  UsageError);
  CHECK_NOTHROW(checked("cylinder.toml", {"process.scan_speed_mm_s=51"}, ""));
  CHECK_NOTHROW(checked("cylinder.toml", {"run.time_scale=10"}, "in-process"));
  CHECK_NOTHROW(checked("ice-small.toml", {"run.time_scale=10"}, ""));
  CHECK_NOTHROW(checked("demo.toml", {}, ""));
}

TEST_CASE("A folder that is no run is refused by what it lacks") {
  const Scratch scratch("no-run");
  CHECK_THROWS_AS(runs::RunFolder::open(scratch / "none"), UsageError);
  std::filesystem::create_directory(scratch / "run");
  for (const char* part : {"experiment.toml", "provenance.json", "nodes"}) {
    CHECK_THROWS_WITH(runs::RunFolder::open(scratch / "run"),
                      Contains("is no run folder: it has no " + std::string(part)));
    CHECK_THROWS_AS(runs::RunFolder::open(scratch / "run"), UsageError);
    if (part == std::string("nodes"))
      std::filesystem::create_directory(scratch / "run" / part);
    else
      write_file(scratch / "run" / part, std::vector<std::byte>{});
  }
  CHECK_THROWS_WITH(runs::RunFolder::open(scratch / "run"), Contains("provenance.json"));  // empty: no JSON
}

TEST_CASE("A folder where a file is wanted is called a folder") {
  const Scratch scratch("folder");
  std::filesystem::create_directory(scratch / "run");
  CHECK_THROWS_WITH(load_experiment(scratch / "run"), Contains("run: is a folder, not a file"));
  for (const LogAction action : {LogAction::kVerify, LogAction::kCat, LogAction::kRepair}) {
    LogOptions o;
    o.action = action;
    o.file = (scratch / "run").string();
    CHECK_THROWS_WITH(run_log(o), Contains("is a folder; give a file in it: log.lcm"));
    CHECK_THROWS_AS(run_log(o), UsageError);
  }
}

TEST_CASE("A document that cannot be written leaves nothing behind") {
  const Scratch scratch("half");
  std::filesystem::create_directory(scratch / "taken");
  CHECK_THROWS_WITH(write_file_atomically(scratch / "taken", "text"),
                    Contains("taken") && Contains("directory"));
  CHECK_FALSE(std::filesystem::exists(scratch / "taken.part"));
  CHECK_THROWS_WITH(write_file_atomically(scratch / "none" / "x", "text"), Contains("No such file"));
}
