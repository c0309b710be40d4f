// firn runs, firn help, firn config find and explain, and the commands that a running print refuses.
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <ctime>
#include <map>

#include "config/experiment.h"
#include "config/include.h"
#include "files/json.h"
#include "runs/folder/run_folder.h"
#include "runs/folder/run_lock.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Json = nlohmann::json;

/// A folder with runs of given ages and outcomes beside things that are no runs.
struct Runs {
  explicit Runs(const std::string& name) : folder(fresh_folder("runs-" + name)) {
    fs::create_directories(folder / "notes");
    write_file_text(folder / "notes" / "a.txt", "of somebody");
    write_file_text(folder / "plan.txt", "of somebody");
  }
  fs::path add(const std::string& name, double days_old, const std::string& outcome = "finished") {
    const fs::path run = folder / name;
    fs::copy(golden("v1-mpc"), run, fs::copy_options::recursive);
    Json provenance = Json::parse(file_text(run / "provenance.json"));
    const std::time_t at = std::time(nullptr) - std::time_t(days_old * 86'400.0);
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&at));
    provenance["started_utc"] = text;
    write_file_text(run / "provenance.json", provenance.dump(2));
    Json result = Json::parse(file_text(run / "result.json"));
    result["outcome"] = outcome;
    if (outcome.empty())
      fs::remove(run / "result.json");
    else
      write_file_text(run / "result.json", result.dump(2));
    return run;
  }
  Said clean(std::vector<std::string> words) const {
    words.insert(words.begin(), {"runs", "clean", "--runs", folder.string()});
    return firn_says(words);
  }
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      all[entry.path().string()] = entry.is_regular_file() ? file_text(entry.path()) : "";
    return all;
  }
  std::vector<std::string> left() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
    std::ranges::sort(names);
    return names;
  }
  fs::path folder;
};

std::vector<std::string> named(const Said& said) {
  std::vector<std::string> names;
  for (const Json& run : Json::parse(said.out)) names.push_back(fs::path(run.at("run")).filename());
  return names;
}

using Names = std::vector<std::string>;

TEST_CASE("firn key and firn say name a run that nobody prints") {
  Runs runs("own");
  const std::string run = runs.add("one", 1.0).string();
  for (const std::vector<std::string>& words : {std::vector<std::string>{"key", run},
                                                {"key", run, "--as", "room", "--json"},
                                                {"say", run, "OWN_VALUES"}}) {
    const Said said = firn_says(words);
    CHECK(said.code == 2);
    CHECK(said.out.empty());
    CHECK_THAT(said.err, Contains(run) && Contains("is not running"));
  }
}

TEST_CASE("firn runs collect says that a run was printed on one computer") {
  Runs runs("collect");
  const Said said = firn_says({"runs", "collect", runs.add("one", 1.0).string()});
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("was printed on one computer"));
}

TEST_CASE("firn runs clean without --yes names what it would remove, and touches nothing") {
  Runs runs("dry");
  runs.add("old", 40.0);
  runs.add("stopped", 3.0, "stopped safely");
  runs.add("new", 0.1);
  const auto before = runs.contents();
  for (const Names& words : {Names{"--older-than", "30"}, Names{"--keep", "1"}, Names{"--keep", "0"},
                             Names{"--outcome", "stopped safely"}, Names{"--older-than", "0"}}) {
    const Said said = runs.clean(words);
    CHECK(said.code == 0);
    CHECK_THAT(said.err, Contains("nothing was removed; --yes removes them"));
    CHECK((runs.contents() == before));
  }
  CHECK_THAT(runs.clean({"--older-than", "30"}).out,
             Contains("old") && Contains("1 runs, ") && !Contains("new"));
  CHECK(named(runs.clean({"--keep", "1", "--json"})) == Names{"old", "stopped"});
  CHECK(named(runs.clean({"--outcome", "stopped safely", "--json"})) == Names{"stopped"});
  CHECK(named(runs.clean({"--keep", "1", "--older-than", "30", "--json"})) == Names{"old"});
  CHECK(named(runs.clean({"--older-than", "400", "--json"})).empty());
}

TEST_CASE("firn runs clean --yes removes the runs that it names, and nothing else") {
  Runs runs("clean");
  runs.add("a", 40.0);
  runs.add("b", 20.0, "");
  runs.add("c", 10.0);
  runs.add("d", 1.0);
  CHECK(runs.clean({"--older-than", "30", "--yes"}).code == 0);
  CHECK(runs.left() == Names{"b", "c", "d", "notes", "plan.txt"});
  CHECK(runs.clean({"--outcome", "interrupted", "--yes"}).code == 0);
  CHECK(runs.left() == Names{"c", "d", "notes", "plan.txt"});
  CHECK(named(runs.clean({"--keep", "1", "--yes", "--json"})) == Names{"c"});
  CHECK(runs.left() == Names{"d", "notes", "plan.txt"});
  const Said nothing = runs.clean({"--keep", "1", "--yes"});
  CHECK(nothing.code == 0);
  CHECK_THAT(nothing.out, Contains("no run to remove"));
  CHECK(runs.left() == Names{"d", "notes", "plan.txt"});
}

TEST_CASE("firn runs clean without a criterion, or with one that is no number of days, removes nothing") {
  Runs runs("criterion");
  runs.add("a", 40.0);
  for (const Names& words : {Names{}, Names{"--older-than", "nan"}, Names{"--older-than", "-1"},
                             Names{"--older-than", "soon"}, Names{"--keep", "-1"}, Names{"--keep", "1.5"}}) {
    Names all = words;
    all.push_back("--yes");
    const Said said = runs.clean(all);
    INFO(Catch::StringMaker<Names>::convert(all) << said.err);
    CHECK(said.code == 2);
    CHECK(fs::exists(runs.folder / "a" / "nodes"));
  }
}

TEST_CASE("firn runs clean never removes a run that somebody prints, whatever its files hold") {
  Runs runs("running");
  const fs::path run = runs.add("busy", 40.0);
  const runs::RunLock held(run, runs::RunUse::kPrint);
  runs.add("idle", 40.0);
  CHECK(named(runs.clean({"--keep", "0", "--json"})) == Names{"idle"});
  write_file_text(run / "provenance.json", "{");
  CHECK(runs.clean({"--keep", "0", "--yes"}).code == 0);
  CHECK(runs.left() == Names{"busy", "notes", "plan.txt"});
}

TEST_CASE("firn runs lists runs by age with outcome, layers and size, and finds them by a word") {
  Runs runs("list");
  runs.add("b-new", 1.0);
  runs.add("a-newest", 0.5, "stopped safely");
  runs.add("c-old", 9.0, "");
  const std::string in = runs.folder.string();
  const Json all = Json::parse(firn_says({"runs", "--runs", in, "--json"}).out);
  CHECK(named(firn_says({"runs", "list", "--runs", in, "--json"})) == Names{"c-old", "b-new", "a-newest"});
  CHECK(all.at(0).at("outcome") == "interrupted");
  CHECK(all.at(1).at("outcome") == "finished");
  CHECK(all.at(1).at("layers") > 0);
  CHECK(all.at(1).at("bytes") > 1000);
  CHECK(named(firn_says({"runs", "find", "SAFELY", "--runs", in, "--json"})) == Names{"a-newest"});
  CHECK(named(firn_says({"runs", "find", "cuboid", "--runs", in, "--json"})).size() == 3);
  for (const char* word : {"helical", "diameter_mm"})  // every experiment has the key
    CHECK_THAT(firn_says({"runs", "find", word, "--runs", in}).out, Contains("no run meets the condition"));
  CHECK(firn_says({"runs", "find", "--runs", in}).code == 2);
  CHECK(firn_says({"runs", "burn", "--runs", in}).code == 2);
  CHECK(firn_says({"runs", "pack", "--runs", in}).code == 2);
  CHECK_THAT(firn_says({"runs", "--runs", in + "/nowhere"}).err, Contains("nowhere: no such folder"));
}

TEST_CASE("firn runs pack and expand give the records back byte for byte") {
  Runs runs("pack");
  const std::string run = runs.add("a", 1.0).string();
  const auto before = runs.contents();
  const auto compared = [&] { return Json::parse(firn_says({"replay", run, "--json"}).out).at("nodes"); };
  const Json plain = compared();
  REQUIRE(firn_says({"runs", "pack", run}).code == 0);
  CHECK_FALSE((runs.contents() == before));
  CHECK(compared() == plain);
  CHECK_THAT(firn_says({"runs", "expand", run}).out, Contains(run) && Contains(" -> "));
  CHECK((runs.contents() == before));
  CHECK_THAT(firn_says({"runs", "pack", (runs.folder / "notes").string()}).err, Contains("is no run folder"));
}

TEST_CASE("A running print is neither resumed nor replayed nor packed: is running, with its pid") {
  const fs::path run = golden_copy("v1-mpc", "running-print");
  const runs::RunLock held(run, runs::RunUse::kPrint);
  const std::string running = "is running (pid " + std::to_string(::getpid()) + ")";
  for (const Names& words :
       {Names{"print", "--resume", run.string()},
        Names{"print", "--resume", run.string(), "--bus", "in-process"},
        Names{"print", "--resume", run.string(), "--detach"}, Names{"replay", run.string()},
        Names{"runs", "pack", run.string()}, Names{"runs", "expand", run.string()}}) {
    const Said said = firn_says(words);
    INFO(said.out << said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(running));
  }
}

TEST_CASE("An order to a print that is over is refused, and says how it goes on") {
  const std::string run = golden_copy("v1-mpc", "order-after").string();
  for (const Names& order : {Names{"pause"}, Names{"stop"}, Names{"set", "control.max_layers=300"}}) {
    Names words{"ctl", run};
    words.insert(words.end(), order.begin(), order.end());
    const Said said = firn_says(words);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains("is not running") && Contains("firn print --resume " + run));
  }
  CHECK_THAT(firn_says({"ctl", run, "dance"}).err, Contains("'dance'") && Contains("finish-layer"));
  CHECK(firn_says({"attach", run}).code == 2);
}

TEST_CASE("A print that waits at control.max_layers says how it goes on, and does so") {
  const fs::path folder = fresh_folder("max-layers");
  const std::string runs = (folder / "runs").string();
  const Said first = firn_says({"print", std::string(FIRN_SOURCE_DIR) + "/tests/replay/golden/tiny.toml",
                                "--bus", "in-process", "--runs", runs, "--set", "control.max_layers=1"});
  CHECK(first.code == 3);
  std::string run;
  for (const auto& entry : fs::directory_iterator(runs)) run = entry.path().string();
  INFO(first.out << first.err);
  CHECK_THAT(first.out + first.err, Contains("--resume " + run) && Contains("control.max_layers"));
  const Names resume{"print", "--resume", run, "--bus", "in-process", "--set"};
  const auto with = [&](const std::string& assignment) {
    Names words = resume;
    words.push_back(assignment);
    return firn_says(words);
  };
  CHECK_THAT(with("grid.nx=9").err, Contains("--resume --set: grid.nx"));
  CHECK(with("grid.nx=9").code == 2);
  CHECK(with("control.max_layers=many").code == 2);
  const Said rest = with("control.max_layers=100");
  INFO(rest.out << rest.err);
  CHECK(rest.code == 0);
  CHECK(firn_says({"replay", run}).code == 0);
  CHECK(firn_says({"audit", run}).code == 0);
}

TEST_CASE("firn help finds every command's page, and words wherever a page has them") {
  for (const auto& entry : fs::directory_iterator(fs::path(FIRN_SOURCE_DIR) / "docs" / "commands")) {
    const std::string name = entry.path().stem();
    CHECK(firn_says({"help", name}).out == file_text(entry.path()));
  }
  CHECK_THAT(firn_says({"help", "pause"}).out, Contains("commands/ctl"));
  CHECK_THAT(firn_says({"help", "finish-layer"}).out, Contains("commands/ctl"));
  CHECK_THAT(firn_says({"help", "expand"}).out, Contains("commands/runs"));
  CHECK_THAT(firn_says({"help", "scan", "speed"}).out, Contains("key process.scan_speed_mm_s"));
  CHECK(firn_says({"help", "prnt"}).err == "firn help: no page prnt; did you mean: firn help print\n");
  CHECK(firn_says({"help", "compair"}).err ==
        "firn help: no page compair; did you mean: firn help compare\n");
  CHECK(firn_says({"help", "xyzzyx"}).err ==
        "no page, section or key mentions it; firn help lists the pages\n");
  const Said nothing = firn_says({"help", "xylophone"});
  CHECK(nothing.code == 1);
  CHECK_THAT(nothing.err, Contains("no page, section or key mentions it"));
}

TEST_CASE("firn config finds keys by words of their sentences and suggests the key that was meant") {
  CHECK_THAT(firn_says({"config", "find", "scan", "speed"}).out,
             Contains("process.scan_speed_mm_s = 15.0 mm/s"));
  CHECK(firn_says({"config", "find", "xylophone"}).code == 1);
  CHECK_THAT(firn_says({"config", "explain", "control.max_layers"}).out,
             Contains("integer, [1, 1e+06]") && Contains("firn ctl RUN set control.max_layers="));
  CHECK_THAT(firn_says({"config", "explain", "scan.speed"}).err, Contains("process.scan_speed_mm_s"));
  CHECK_THAT(firn_says({"config", "explain", "max_layers"}).err, Contains("control.max_layers"));
  const fs::path file = fresh_folder("mistakes") / "bad.toml";
  write_file_text(file, "[part]\ndiametr_mm = 5\nheight_mm = -3\n[control]\nscheme = \"fuzzy\"\n");
  const Said all = firn_says({"config", "check", file.string()});
  CHECK(all.code == 2);
  CHECK_THAT(all.out + all.err, Contains("part.diametr_mm") && Contains("part.height_mm = -3") &&
                                    Contains("control.scheme = 'fuzzy'"));
}

}  // namespace
}  // namespace firn::test
