// Commands apart from recorded runs: the command line itself, a study's result, plans, calibrations,
// decisions on files, and prints from the first layer to the audit.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "cli/commands.h"
#include "cli/compare_show.h"
#include "cli/options.h"
#include "core/grid/npy.h"
#include "core/grid/random.h"
#include "files/json.h"
#include "print/labs/full_product.h"
#include "report/study/study_analysis.h"
#include "runtime/build_info.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Json = nlohmann::json;
using report::StudyTable;

const std::string kSource = FIRN_SOURCE_DIR;

Json json_of(const Said& said) {
  CAPTURE(said.out, said.err);
  return Json::parse(said.out);
}

// Words at the beginning of the lines under the headings of a help text, but for its options.
std::vector<std::string> subcommands_of(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream in(help);
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty() && line.front() != ' ') inside = line.back() == ':' && line != "Options:";
    if (!inside || line.rfind("  ", 0) != 0 || line.size() < 3 || line[2] == ' ') continue;
    std::istringstream words(line);
    std::string name;
    words >> name;
    names.push_back(name);
  }
  return names;
}

// The command that a line gives, parsed and not carried out.
Call parsed(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  std::vector<const char*> argv;
  for (const std::string& word : words) argv.push_back(word.c_str());
  return parse_command_line(all_commands(), full_product(), int(argv.size()), argv.data());
}

// Files of the house that a line names.
std::vector<std::string> files_of(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> files;
  for (std::string word; in >> word;)
    if (word.rfind("experiments/", 0) == 0 || word.rfind("labs/", 0) == 0) files.push_back(word);
  return files;
}

StudyTable study(std::size_t arms, std::size_t seeds, double stopped) {
  StudyTable t;
  t.name = "a \"study\"";
  t.metrics = {{"rms_um", "um", "RMS error", 2}, {"time_h", "h", "time", 2}};
  t.parts = {"disc", "wedge"};
  for (std::size_t a = 0; a < arms; ++a) t.arms.push_back("arm" + std::to_string(a));
  for (std::size_t s = 0; s < seeds; ++s) t.seeds.push_back(s + 1);
  RandomStream random(81, Purpose::kTest);
  for (std::size_t n = 0; n < arms * 2 * seeds; ++n) {
    const bool ends = random.uniform() >= stopped;
    t.runs.push_back({ends,
                      ends ? "finished" : "stopped",
                      "",
                      {5.0 + double(n / (2 * seeds)) + random.normal(), 2.0 + random.uniform()}});
  }
  return t;
}

std::string npy_file(const fs::path& file, const HeightMap& map) {
  const std::vector<std::byte> bytes = to_npy(map);
  write_file_text(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return file.string();
}

TEST_CASE("Every command that the help names has a help of its own and prints it on stdout") {
  const Said help = firn_says({"--help"});
  CHECK(help.code == 0);
  CHECK(help.err.empty());
  const std::vector<std::string> commands = subcommands_of(help.out);
  CHECK(commands.size() >= 15);
  for (const std::string& command : commands) {
    const Said said = firn_says({command, "--help"});
    CAPTURE(command, said.err);
    CHECK(said.code == 0);
    CHECK(!said.out.empty());
    CHECK(said.err.empty());
  }
}

TEST_CASE("Every command refuses an option that it does not know, by the option's name, with exit code 2") {
  for (const std::string& command : subcommands_of(firn_says({"--help"}).out)) {
    const Said said = firn_says({command, "--no-such-option"});
    CAPTURE(command, said.err, said.out);
    CHECK(said.code == 2);
    CHECK(!said.err.empty());
    CHECK(said.out.empty());
  }
}

TEST_CASE("A command that is misspelt by a letter is answered with the one that was meant") {
  for (const std::string& command : subcommands_of(firn_says({"--help"}).out)) {
    if (command.size() < 5) continue;
    std::string wrong = command;
    wrong.erase(2, 1);
    const Said said = firn_says({wrong});
    CAPTURE(wrong, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains("unknown command '" + wrong + "'") && Contains("is " + command));
  }
}

TEST_CASE("firn alone says what it is for and gives three commands that it knows") {
  const Said said = firn_says({});
  CHECK(said.code == 0);
  CHECK(said.err.empty());
  std::istringstream in(said.out);
  int examples = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("  firn ", 0) != 0) continue;
    ++examples;
    line.resize(line.find("   ", 2));  // the command, without its purpose
    CHECK(parsed(line).problem.empty());
  }
  CHECK(examples == 3);
}

TEST_CASE("Every command has examples that parse, name files that exist, and end its help") {
  for (const Command& c : all_commands()) {
    INFO(c.name);
    CHECK(std::string(c.group) != Command{}.group);
    CHECK(*c.examples.front().line);
    const std::string help = firn_says({c.name, "--help"}).out;
    for (const Example& e : c.examples) {
      if (!*e.line) continue;
      const Call call = parsed(e.line);
      CAPTURE(e.line, call.problem);
      CHECK(call.problem.empty());
      CHECK(call.command.substr(0, call.command.find(' ')) == c.name);
      CHECK(*e.purpose);
      CHECK_THAT(help, Contains(std::string("  ") + e.line + "\n      " + e.purpose + "\n"));
      for (const std::string& file : files_of(e.line)) CHECK(fs::exists(fs::path(kSource) / file));
    }
  }
}

TEST_CASE("An example that does not parse would be told") {
  CHECK_THAT(parsed("firn print --no-such-option").problem, Contains("--no-such-option"));
  CHECK_THAT(parsed("firn pint part.toml").problem, Contains("pint"));
  CHECK(parsed("firn print part.toml").problem.empty());
}

TEST_CASE("The commands of a group stand together under one heading") {
  std::vector<std::string> groups;
  for (const Command& c : all_commands())
    if (groups.empty() || groups.back() != c.group) groups.push_back(c.group);
  for (const std::string& group : groups) CHECK(std::ranges::count(groups, group) == 1);
  const std::string help = firn_says({"--help"}).out;
  std::size_t at = 0;
  for (const std::string& group : groups) {
    CAPTURE(group);
    at = help.find("\n" + group + ":\n", at);
    REQUIRE(at != std::string::npos);
  }
}

TEST_CASE("A group of commands without its verb is a usage error") {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"config"}, {"log"}, {"tune"}, {"log", "verify"}, {"config", "check"}})
    CHECK(firn_says(words).code == 2);
}

TEST_CASE("firn --version names the program, its version and its commit in one line") {
  const Said said = firn_says({"--version"});
  CHECK(said.code == 0);
  CHECK(said.out == build_name() + "\n");
  CHECK_THAT(said.out, Catch::Matches("firn [0-9]+[.][0-9]+[.][0-9]+ [(]("
                                      "[0-9a-f]{12}(-dirty-[0-9a-f]{12})?, 20[0-9]{2}-[0-9]{2}-[0-9]{2}|"
                                      "without a commit)[)]\n"));
}

TEST_CASE("A study as JSON has the numbers of its analysis, for every scheme and every pair") {
  const StudyTable t = study(3, 8, 0.1);
  const report::StudyAnalysis a = report::analyse(t);
  const Json j = Json::parse(study_json(t, a));
  CHECK(j.at("study") == t.name);
  CHECK(j.at("answer") == a.answer);
  CHECK(j.at("seeds") == 8);
  CHECK(j.at("primary") == "rms_um");
  REQUIRE(j.at("schemes").size() == 3);
  REQUIRE(j.at("comparisons").size() == a.comparisons.size());
  for (std::size_t arm = 0; arm < 3; ++arm) {
    const Json& scheme = j.at("schemes").at(arm);
    CHECK(scheme.at("failed_prints") == a.stopped[arm]);
    CHECK(scheme.at("metrics").size() == 2 * 3);
    for (const Json& m : scheme.at("metrics"))
      if (m.at("metric") == "rms_um" && m.at("part") == "") CHECK(m.at("mean") == a.summaries[arm].mean);
  }
  for (std::size_t n = 0; n < a.comparisons.size(); ++n) {
    const Json& c = j.at("comparisons").at(n);
    const report::ArmComparison& want = a.comparisons[n];
    CHECK(c.at("a") == t.arms[want.a]);
    CHECK(c.at("b") == t.arms[want.b]);
    CHECK(c.at("holm_p") == want.holm_p);
    CHECK(c.at("failed_a") == want.failed_a);
    CHECK(c.at("distinguishable") == want.told_apart());
    CHECK(c.at("better").is_null() != want.told_apart());
  }
}

TEST_CASE("Numbers of a study that are none are null in its JSON") {
  StudyTable t = study(2, 5, 0.0);
  for (std::size_t n = 0; n < 10; ++n) t.runs[n] = {false, "error", "", {NAN, NAN}};
  const std::string text = study_json(t, report::analyse(t));
  const Json j = Json::parse(text);
  for (const char* word : {"nan", "inf"}) CHECK(text.find(word) == std::string::npos);
  CHECK(j.at("schemes").at(0).at("failed_prints") == 10);
  CHECK(j.at("comparisons").at(0).at("low").is_null());
}

TEST_CASE("A study's text ends with the answer, and its table has the prints that stopped of each scheme") {
  const StudyTable t = study(4, 6, 0.2);
  const report::StudyAnalysis a = report::analyse(t);
  const std::string text = study_text(t, a, {{"control.scheme", "", {"a", "b", "c", "d"}}});
  CHECK(text.substr(text.size() - a.answer.size() - 1) == a.answer + "\n");
  CHECK_THAT(text, Contains("control.scheme") && Contains("arm2: c"));
  for (std::size_t arm = 0; arm < 4; ++arm) {
    const std::size_t at = text.find("\n" + t.arms[arm] + " ");
    REQUIRE(at != text.npos);
    std::istringstream row(text.substr(at + 1));
    std::string name, stopped;
    std::size_t seeds = 0;
    row >> name >> seeds >> stopped;
    CHECK(seeds == a.summaries[arm].seeds);
    CHECK(stopped == std::to_string(a.stopped[arm]) + "/12");
  }
}

TEST_CASE("A study with too few seeds says so before its table") {
  const StudyTable t = study(4, 6, 0.0);
  const std::string text = study_text(t, report::analyse(t), {});
  const std::size_t note = text.find("6 seeds cannot tell 6 pairs apart");
  REQUIRE(note != text.npos);
  CHECK(note < text.find("arm0 "));
}

TEST_CASE("A decision on a surface at its target is to end, and on one a layer below to print") {
  const fs::path folder = fresh_folder("decide");
  const GridSpec grid{10, 8};
  const std::string target = npy_file(folder / "target.npy", HeightMap(grid, 0.1));
  const auto decision = [&](double below_mm) {
    const std::string height = npy_file(folder / "height.npy", HeightMap(grid, 0.1 - below_mm));
    return json_of(firn_says({"decide", "--height", height, "--target", target, "--json"}));
  };
  const Json at = decision(0.0), below = decision(0.012);
  CHECK(at.at("decision") == "end");
  CHECK(at.at("droplets") == 0);
  CHECK(below.at("decision") == "print");
  CHECK(below.at("droplets").get<int>() > 20);
  CHECK(below.at("objective_mm").get<double>() < below.at("objective_none_mm").get<double>());
  CHECK(below.at("objective_none_mm").get<double>() == Approx(0.012).epsilon(0.5));
}

TEST_CASE("The droplets that firn decide writes are those that it counts") {
  const fs::path folder = fresh_folder("decide-output");
  const GridSpec grid{9, 7};
  RandomStream random(82, Purpose::kTest);
  HeightMap height(grid);
  for (double& h : height.cells) h = 0.1 - random.uniform(0.004, 0.015);
  const std::string out = (folder / "drops.npy").string();
  const Json j = json_of(firn_says({"decide", "--height", npy_file(folder / "h.npy", height), "--target",
                                    npy_file(folder / "t.npy", HeightMap(grid, 0.1)), "-o", out, "--json"}));
  const std::string bytes = file_text(out);
  REQUIRE(bytes.size() > 63);
  int total = 0;
  for (std::size_t n = bytes.size() - 63; n < bytes.size(); ++n)
    total += static_cast<unsigned char>(bytes[n]);
  CHECK(j.at("droplets") == total);
}

TEST_CASE("firn decide refuses files that are missing, cut or of another shape by their names") {
  const fs::path folder = fresh_folder("decide-bad");
  const std::string height = npy_file(folder / "h.npy", HeightMap({6, 5}, 0.09)),
                    other = npy_file(folder / "other.npy", HeightMap({5, 6}, 0.1)),
                    cut = (folder / "cut.npy").string(), none = (folder / "none.npy").string();
  write_file_text(cut, file_text(height).substr(0, 150));
  for (const std::string& target : {other, cut, none}) {
    const Said said = firn_says({"decide", "--height", height, "--target", target});
    CAPTURE(target, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(target));
    CHECK(said.out.empty());
  }
}

TEST_CASE("A plan that keeps its limits says so in JSON, and its longest ratio is at most one") {
  const fs::path folder = fresh_folder("plan");
  const fs::path paths = folder / "line.csv";
  write_file_text(paths, "x_mm,y_mm\n0,0\n60,0\n60,40\n");
  const Said said =
      firn_says({"plan", paths.string(), "--machine", kSource + "/labs/cobra600.toml", "--origin", "330,-20",
                 "--json", "--threads", "1", "-o", (folder / "out.traj").string()});
  CAPTURE(said.out, said.err);
  CHECK(said.code == 0);
  const Json j = json_of(said);
  CHECK(j.at("paths") == 1);
  CHECK(!j.at("limits").empty());
  for (const Json& limit : j.at("limits")) CHECK(limit.at("ratio").get<double>() <= 1.0);
  CHECK(j.at("duration_s").get<double>() >= j.at("lower_bound_s").get<double>());
  CHECK(j.at("duration_s").get<double>() > 100.0 / 125.0);  // 100 mm at 125 mm/s
  CHECK(fs::file_size(folder / "out.traj") > 1000);
  CHECK(firn_says({"log", "verify", (folder / "out.traj").string()}).code == 0);
}

TEST_CASE("A path that the arm cannot reach makes no file, exit code 1 and a message that names it") {
  const fs::path folder = fresh_folder("plan-far");
  write_file_text(folder / "far.csv", "x_mm,y_mm\n0,0\n6000,0\n");
  const Said said =
      firn_says({"plan", (folder / "far.csv").string(), "--machine", kSource + "/labs/cobra600.toml", "-o",
                 (folder / "out.traj").string(), "--threads", "1"});
  CHECK(said.code == 1);
  CHECK_THAT(said.err + said.out, Contains("far.csv"));
  CHECK_FALSE(fs::exists(folder / "out.traj"));
}

TEST_CASE("Path files with damage are refused by file and line") {
  const fs::path folder = fresh_folder("plan-bad");
  const std::vector<std::pair<std::string, std::string>> files{{"x_mm,y_mm\n0,0\nnan,1\n", "bad.csv:3"},
                                                               {"x_mm,y_mm\n0,0\n1\n", "bad.csv:3"},
                                                               {"a,b\n0,0\n1,1\n", "bad.csv"},
                                                               {"x_mm,y_mm\n0,0\n1e9,0\n", "bad.csv:3"},
                                                               {"", "bad.csv"}};
  for (const auto& [text, named] : files) {
    write_file_text(folder / "bad.csv", text);
    const Said said =
        firn_says({"plan", (folder / "bad.csv").string(), "--machine", kSource + "/labs/cobra600.toml"});
    CAPTURE(text, said.err);
    CHECK(said.code != 0);
    CHECK_THAT(said.err, Contains(named));
  }
}

TEST_CASE("firn spy refuses what it cannot watch: an ended run, a print in one process, no layers") {
  const Said ended = firn_says({"spy", golden("v1-mpc").string(), "--screenshot", "x.png"});
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err, Contains("v1-mpc") && Contains("does not print now"));
  const Said here = firn_says({"spy", "--bus", "in-process"});
  CHECK(here.code == 2);
  CHECK_THAT(here.err, Contains("in-process"));
  CHECK(firn_says({"spy", "--bus", "no-url"}).code == 2);
  const Said none = firn_says(
      {"spy", "--bus", "udpm://239.255.76.67:7667?ttl=0", "--screenshot", "x.png", "--layers", "0"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("--layers"));
}

TEST_CASE("firn print refuses an experiment that is missing or damaged before it makes a folder") {
  const fs::path folder = fresh_folder("print-bad");
  write_file_text(folder / "bad.toml", "[grid\n");
  for (const char* name : {"bad.toml", "none.toml"}) {
    const Said said = firn_says(
        {"print", (folder / name).string(), "--bus", "in-process", "--runs", (folder / "runs").string()});
    CAPTURE(name, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(name));
  }
  const Said nothing = firn_says({"print", "--runs", (folder / "runs").string()});
  CHECK(nothing.code == 2);
  const Said resume = firn_says({"print", "--resume", (folder / "nowhere").string()});
  CHECK(resume.code == 2);
  CHECK_THAT(resume.err, Contains("nowhere"));
  CHECK_FALSE(fs::exists(folder / "runs"));
}

TEST_CASE("A print in one process leaves a run that verifies, replays, audits and reports, all of one mind") {
  const fs::path folder = fresh_folder("print");
  const Said said = firn_says({"print", kSource + "/tests/replay/golden/tiny.toml", "--bus", "in-process",
                               "--runs", (folder / "runs").string(), "--json"});
  const Json print = json_of(said);
  CHECK(said.code == 0);
  std::vector<fs::path> runs;
  for (const auto& entry : fs::directory_iterator(folder / "runs"))
    if (entry.is_directory() && !entry.is_symlink()) runs.push_back(entry.path());
  REQUIRE(runs.size() == 1);
  const std::string run = runs[0].string();
  const Json result = Json::parse(file_text(runs[0] / "result.json"));
  CHECK(result.at("status") == 0);
  CHECK(firn_says({"log", "verify", run + "/log.lcm"}).code == 0);
  CHECK(firn_says({"replay", run}).code == 0);
  const Json audit = json_of(firn_says({"audit", run, "--json"}));
  CHECK(audit.at("clean") == true);
  CHECK(audit.at("layers") == result.at("layers"));
  CHECK(firn_says({"report", run, "-o", (folder / "r.html").string(), "--no-replay"}).code == 0);
  std::istringstream csv(file_text(runs[0] / "metrics.csv"));
  std::vector<std::string> head, last;
  for (std::string line; std::getline(csv, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    (head.empty() ? head : last) = cells;
  }
  const auto column = [&](const std::string& name) {
    return last.at(std::size_t(std::find(head.begin(), head.end(), name) - head.begin()));
  };
  CHECK(audit.at("commanded") == std::stoll(column("drops_total")));
  CHECK(column("layer") == result.at("layers").dump());
}

TEST_CASE("A print to a tolerance that it misses exits with 4, and one that it keeps with 0") {
  const fs::path folder = fresh_folder("print-tolerance");
  const auto code = [&](const char* um) {
    return firn_says({"print", kSource + "/tests/replay/golden/tiny.toml", "--bus", "in-process", "--runs",
                      (folder / "runs").string(), "--tolerance", um})
        .code;
  };
  CHECK(code("0.0001") == 4);
  CHECK(code("1000") == 0);
}

TEST_CASE("The same experiment prints the same droplets each time, another seed of nature other heights") {
  const fs::path folder = fresh_folder("print-twice");
  const auto rms = [&](const std::string& seed) {
    const Said said =
        firn_says({"print", kSource + "/tests/replay/golden/tiny.toml", "--bus", "in-process", "--runs",
                   (folder / "runs").string(), "--json", "--set", "plant.seed=" + seed});
    CAPTURE(said.err);
    REQUIRE(said.code == 0);
    return json_of(said).at("rms_um").get<double>();
  };
  const double first = rms("3");
  CHECK(rms("3") == first);
  CHECK(rms("4") != first);
}

TEST_CASE("firn calibrate refuses a lab that is missing, a valve that is none and a run without marks") {
  const Said said = firn_says({"calibrate", "laser-offset", "/nonexistent/lab.toml"});
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains("/nonexistent/lab.toml"));
  CHECK(firn_says({"calibrate", "valve-latency", "--valve", "c"}).code == 2);
  CHECK(firn_says({"calibrate", "laser-offset", "--repeats", "0"}).code == 2);
  const Said run = firn_says({"calibrate", golden("v1-mpc").string()});
  CHECK(run.code == 2);
  CHECK(!run.err.empty());
}

TEST_CASE(
    "firn calibrate refuses files that it cannot write and options of other calibrations before the lab "
    "moves") {
  const auto folder = fresh_folder("calibrate-refused");
  const auto refused = [&](std::vector<std::string> words, const std::string& why) {
    words.insert(words.begin(), "calibrate");
    const Said said = firn_says(words);
    CAPTURE(words, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(why) && !Contains(" %  ETA"));
  };
  const std::string lab = kInkjet, out = (folder / "out.toml").string();
  refused({"jet", lab, "-o", "/nonexistent/x.toml"}, "/nonexistent/x.toml: there is no folder /nonexistent");
  refused({"jet", lab, "-o", folder.string()}, folder.string() + ": is a folder");
  refused({"jet", lab, "-o", out, "--plot", "/nonexistent/x.svg"}, "/nonexistent/x.svg: there is no folder");
  refused({"jet", lab, "-o", out, "--plot", lab}, lab + ": would take the place of " + lab);
  refused({"jet", lab, "-o", out, "--plot", out}, out + ": would take the place of " + out);
  refused({"jet", lab, "-o", out, "--speeds", "10"}, "--speeds: not of jet, but of laser-offset");
  refused({"jet", lab, "-o", out, "--rounds", "3"}, "--rounds: not of jet, but of level-table");
  refused({"laser-offset", kIce, "-o", out, "--dwells", "10,20,30"},
          "--dwells: not of laser-offset, but of jet");
  refused({"laser-offset", kIce, "-o", out, "--velocity", "2"},
          "--velocity: not of laser-offset, but of jet");
  CHECK_FALSE(std::filesystem::exists(out));
}

TEST_CASE("firn identify takes a run once, and needs squares for a spacing") {
  const std::string run = golden("v1-mpc").string();
  const Said two = firn_says({"identify", run, run});
  CHECK(two.code == 2);
  CHECK_THAT(two.err, Contains(run + ": this run is given already"));
  const Said spacing = firn_says({"identify", "--spacing", run, run, run});
  CHECK(spacing.code == 2);
  CHECK_THAT(spacing.err, Contains(run));
  CHECK(firn_says({"identify", "--spacing", "--diameter", "-1", run}).code == 2);
}

TEST_CASE("firn identify answers with estimates inside their intervals, or says why it cannot") {
  const Said said = firn_says({"identify", golden("v2-estimator").string(), "--json"});
  const Json j = json_of(said);
  CHECK(j.at("identified").get<bool>() == (said.code == 0));
  CHECK(j.at("reason").get<std::string>().empty() == j.at("identified").get<bool>());
  CHECK(j.at("layers").get<int>() > 0);
  CHECK(j.at("droplets").get<std::int64_t>() > 0);
}

}  // namespace
}  // namespace firn::test
