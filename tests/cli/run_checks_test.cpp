// Replay, audit and log of damaged or changed runs through the command line: all three name the damage, and
// name the same.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "core/grid/random.h"
#include "files/json.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Json = nlohmann::json;

std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(Json::parse(line));
  return lines;
}

Json json_of(const std::vector<std::string>& words) {
  const Said said = firn_says(words);
  CAPTURE(said.out, said.err);
  return Json::parse(said.out);
}

TEST_CASE("With --json each command prints one JSON value on stdout and nothing beside it") {
  const fs::path run = golden_copy("v1-mpc", "json");
  const std::string experiment = std::string(FIRN_SOURCE_DIR) + "/experiments/demo.toml";
  const std::vector<std::vector<std::string>> all{
      {"config", "check", experiment},
      {"config", "dump", experiment},
      {"config", "docs", "-o", (run / "docs.md").string()},
      {"dataflow"},
      {"doctor"},
      {"replay", run.string()},
      {"audit", run.string()},
      {"report", run.string(), "--no-replay", "-o", (run / "r.html").string()},
      {"log", "verify", (run / "log.lcm").string()},
      {"log", "repair", (run / "log.lcm").string()},
      {"tune", "smf"},
      {"identify", run.string()}};
  for (std::vector<std::string> words : all) {
    words.push_back("--json");
    const Said said = firn_says(words);
    CAPTURE(words[0], words[1], said.out, said.err);
    REQUIRE_NOTHROW(Json::parse(said.out));
    CHECK(said.out.back() == '\n');
  }
}

TEST_CASE("firn replay --node replays that node alone, with the steps that the whole replay counts for it") {
  const std::string run = golden("v3-kalman").string();
  const Json whole = json_of({"replay", run, "--json"});
  for (const Json& node : whole.at("nodes")) {
    const std::string name = node.at("node");
    if (name != "controller" && name != "surface_mapper" && name != "stage") continue;
    const Json one = json_of({"replay", run, "--node", name, "--json"});
    CAPTURE(name);
    REQUIRE(one.at("nodes").size() == 1);
    CHECK(one.at("nodes").at(0).at("node") == name);
    CHECK(one.at("nodes").at(0).at("steps") == node.at("steps"));
    CHECK(one.at("nodes").at(0).at("bytes") == node.at("bytes"));
  }
}

TEST_CASE("The verdict of a replay does not depend on the number of threads") {
  const std::string run = golden("v2-two-inks").string();
  Json one = json_of({"replay", run, "--threads", "1", "--json"}),
       many = json_of({"replay", run, "--threads", "5", "--json"});
  for (Json* j : {&one, &many}) j->erase("wall_s");
  CHECK(one == many);
}

TEST_CASE("A byte changed in a node's file is named alike by firn log verify and firn replay") {
  const fs::path run = golden_copy("v1.0-mpc", "checks");
  REQUIRE(firn_says({"runs", "expand", run.string()}).code == 0);
  RandomStream random(91, Purpose::kTest);
  for (const char* node : {"controller", "jet", "surface_mapper"}) {
    const fs::path file = run / "nodes" / (std::string(node) + ".wal");
    const std::string whole = file_text(file);
    std::string bytes = whole;
    const std::size_t at = whole.size() / 2 + random.below(std::uint32_t(whole.size() / 4));
    bytes[at] = char(bytes[at] ^ 16);
    write_file_text(file, bytes);
    const Json verified = json_of({"log", "verify", file.string(), "--json"}),
               replayed = json_of({"replay", run.string(), "--json"});
    CAPTURE(node, at);
    CHECK(verified.at("ok") == false);
    CHECK(replayed.at("identical") == false);
    std::set<std::uint64_t> places;
    for (const Json& d : replayed.at("damage")) {
      CHECK(d.at("file") == "nodes/" + std::string(node) + ".wal");
      places.insert(d.at("offset").get<std::uint64_t>());
    }
    for (const Json& d : verified.at("damage")) CHECK(places.contains(d.at("offset").get<std::uint64_t>()));
    CHECK_FALSE(verified.at("damage").empty());
    write_file_text(file, whole);
  }
  CHECK(firn_says({"replay", run.string()}).code == 0);
}

TEST_CASE(
    "firn log cat of a damaged log prints what is whole as JSON, names the byte on stderr and exits 1") {
  const fs::path run = golden_copy("v1-mpc", "cat-damage");
  const fs::path log = run / "log.lcm";
  const std::size_t events = json_lines(firn_says({"log", "cat", log.string()}).out).size();
  std::string bytes = file_text(log);
  for (std::size_t n = 0; n < 64; ++n) bytes[bytes.size() / 3 + n] = '\x5a';
  write_file_text(log, bytes);
  const Said said = firn_says({"log", "cat", log.string()});
  CHECK(said.code == 1);
  CHECK_THAT(said.err, Contains("log.lcm: byte "));
  const std::vector<Json> lines = json_lines(said.out);
  CHECK(lines.size() <= events);
  CHECK(lines.size() + 20 > events);
}

TEST_CASE("A channel that Firn does not have is noted on stderr, and yields no line") {
  const Said said = firn_says({"log", "cat", (golden("v1-mpc") / "log.lcm").string(), "-c", "LAYER_PLANS"});
  CHECK(said.code == 0);
  CHECK(said.out.empty());
  CHECK_THAT(said.err, Contains("LAYER_PLANS"));
}

TEST_CASE("A node's file shows every message that the log has from that node, with the same numbers") {
  const fs::path run = golden("v1-mpc");
  std::vector<std::int64_t> logged, sent;
  for (const Json& j :
       json_lines(firn_says({"log", "cat", (run / "log.lcm").string(), "-c", "LAYER_PLAN"}).out))
    logged.push_back(j.at("message").at("header").at("seq"));
  const std::string wal = (run / "nodes" / "controller.wal").string();
  for (const Json& record : json_lines(firn_says({"log", "cat", wal, "-c", "LAYER_PLAN"}).out)) {
    if (!record.contains("outputs")) continue;
    for (const Json& output : record.at("outputs"))
      if (output.value("channel", "") == "LAYER_PLAN")
        sent.push_back(output.at("message").at("header").at("seq"));
  }
  CHECK(!logged.empty());
  CHECK(logged == sent);
}

TEST_CASE("The first record of each incarnation is its head, with the configuration that the run holds") {
  const fs::path run = golden("v1-smf-resumed");
  int heads = 0;
  for (const Json& j :
       json_lines(firn_says({"log", "cat", (run / "nodes" / "controller.wal").string()}).out)) {
    if (j.at("kind") != "head") continue;
    CHECK(j.at("node") == "controller");
    CHECK(j.at("incarnation") == heads);
    CHECK_THAT(j.at("config_toml").get<std::string>(), Contains("scheme"));
    ++heads;
  }
  CHECK(heads == 2);
}

TEST_CASE("A missing node's file is no identical run, and its name stands in the verdict") {
  const fs::path run = golden_copy("v1-mpc", "lost-node");
  fs::remove(run / "nodes" / "lamp.wal");
  const Said said = firn_says({"replay", run.string()});
  CHECK(said.code != 0);
  CHECK_THAT(said.out + said.err, Contains("lamp"));
}

TEST_CASE("A file that is missing is a violation for the audit, which names it") {
  const fs::path run = golden_copy("v1-mpc", "audit-missing");
  CHECK(firn_says({"audit", run.string()}).code == 0);
  const auto violation = [&](const std::string& named) {
    const Said said = firn_says({"audit", run.string()});
    CHECK(said.code == 1);
    CHECK_THAT(said.out, Contains("damaged record: " + named));
  };
  fs::rename(run / "nodes" / "controller.wal", run / "controller.wal");
  violation("nodes/controller.wal is missing");
  fs::rename(run / "controller.wal", run / "nodes" / "controller.wal");
  fs::remove(run / "world.rec");
  violation("world.rec is missing");
  fs::remove_all(run / "nodes");
  fs::create_directory(run / "nodes");
  violation("nodes/scheduler.wal is missing");
}

TEST_CASE("A report of two runs tells the settings in which they differ, and only those") {
  const fs::path folder = fresh_folder("two-runs");
  fs::copy(golden("v1-mpc"), folder / "a", fs::copy_options::recursive);
  fs::copy(golden("v1-mpc"), folder / "b", fs::copy_options::recursive);
  fs::copy(golden("v1-smf-resumed"), folder / "c", fs::copy_options::recursive);
  const auto page = [&](const char* other) {
    const std::string file = (folder / "r.html").string();
    REQUIRE(
        firn_says({"report", (folder / "a").string(), (folder / other).string(), "--no-replay", "-o", file})
            .code == 0);
    return file_text(file);
  };
  CHECK_THAT(page("b"), Contains("all runs were configured alike"));
  CHECK_THAT(page("c"), Contains("<code>control.scheme</code>") && !Contains("configured alike"));
}

}  // namespace
}  // namespace firn::test
