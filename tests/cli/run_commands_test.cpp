// Commands that read a run folder or an experiment: output for programs, exit codes, errors that name the
// cause, and agreement between commands that look at the same file.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "config/experiment.h"
#include "config/fields.h"
#include "core/grid/random.h"
#include "files/json.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Json = nlohmann::json;

const std::string kRunsSource = FIRN_SOURCE_DIR;
const std::vector<std::string> kRuns{"v1-mpc", "v2-two-inks", "v2-estimator", "v3-kalman", "v1-smf-resumed"};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Json runs_json(const Said& said) {
  CAPTURE(said.out, said.err);
  return Json::parse(said.out);
}

TEST_CASE("firn config check says ok of every experiment of the repository") {
  int checked = 0;
  for (const auto& entry : fs::directory_iterator(kRunsSource + "/experiments")) {
    if (entry.path().extension() != ".toml" || entry.path().filename() == "ice-helical-gear.toml") continue;
    const Said said = firn_says({"config", "check", entry.path().string(), "--json"});
    CAPTURE(entry.path().string());
    CHECK(said.code == 0);
    CHECK(runs_json(said) == Json{{"ok", true}, {"file", entry.path().string()}});
    ++checked;
  }
  CHECK(checked >= 8);
}

TEST_CASE("firn config check names file, line, key and problem of the first mistake, as text and as JSON") {
  const fs::path file = fresh_folder("config") / "bad.toml";
  struct Mistake {
    std::string text, key;
    int line;
  };
  for (const Mistake& m :
       {Mistake{"[control]\nscheme = \"mpz\"\n", "control.scheme", 2},
        Mistake{"\n\n[grid]\nnx = -3\n", "grid.nx", 4}, Mistake{"[grid]\nnix = 3\n", "grid.nix", 2},
        Mistake{"[control]\nmax_layers = \"many\"\n", "control.max_layers", 2}}) {
    write_file_text(file, m.text);
    const Said said = firn_says({"config", "check", file.string(), "--json"});
    const Json j = runs_json(said);
    CAPTURE(m.text, said.out);
    CHECK(said.code == 2);
    CHECK(j.at("ok") == false);
    CHECK(j.at("file") == file.string());
    CHECK(j.at("key") == m.key);
    CHECK(j.at("line") == m.line);
    CHECK(!j.at("problem").get<std::string>().empty());
    const Said words = firn_says({"config", "check", file.string()});
    CHECK(words.code == 2);
    CHECK(words.out.empty());
    CHECK_THAT(words.err, Contains(file.string()) && Contains(m.key));
  }
}

TEST_CASE("firn config check refuses inputs that no print can follow, as text and as JSON") {
  const std::string file = kRunsSource + "/experiments/aerosol-fig7.toml";
  const std::vector<std::string> far{
      "config", "check", file, "--set", "camera.use=on", "--set", "aerosol.camera_x_mm=90"};
  const Said words = firn_says(far);
  CHECK(words.code == 2);
  CHECK_THAT(words.err, Contains(file) && Contains("segments[0]") && Contains("it reaches -50 to 50 mm") &&
                            Contains("aerosol.camera_x_mm = 90"));
  std::vector<std::string> as_json = far;
  as_json.push_back("--json");
  const Said said = firn_says(as_json);
  CHECK(said.code == 2);
  CHECK(runs_json(said).at("ok") == false);
  CHECK_THAT(runs_json(said).at("problem").get<std::string>(), Contains("it reaches -50 to 50 mm"));
}

TEST_CASE("Whatever an experiment file holds, firn config check answers in words") {
  const fs::path file = fresh_folder("config-fuzz") / "x.toml";
  const std::string whole = file_text(kRunsSource + "/experiments/demo.toml");
  RandomStream random(71, Purpose::kTest);
  for (int trial = 0; trial < 60; ++trial) {
    std::string text = whole.substr(0, random.below(std::uint32_t(whole.size())));
    for (std::uint32_t n = random.below(4); n > 0 && !text.empty(); --n)
      text[random.below(std::uint32_t(text.size()))] = char(random.below(256));
    write_file_text(file, text);
    const Said said = firn_says({"config", "check", file.string()});
    CAPTURE(text);
    CHECK((said.code == 0 || said.code == 2));
    if (said.code == 2) CHECK(!said.err.empty());
  }
}

TEST_CASE("A dumped experiment reads back as the same experiment") {
  const fs::path file = fresh_folder("dump") / "dumped.toml";
  for (const char* name : {"demo.toml", "gear.toml", "wedge.toml", "ice-small.toml"}) {
    const Said said = firn_says({"config", "dump", kRunsSource + "/experiments/" + name});
    REQUIRE(said.code == 0);
    write_file_text(file, said.out);
    CAPTURE(name);
    CHECK(firn_says({"config", "dump", file.string()}).out == said.out);
  }
}

TEST_CASE("firn config dump --json holds every field once with its resolved value, overrides included") {
  const Said said = firn_says({"config", "dump", kRunsSource + "/experiments/demo.toml", "--json", "--set",
                               "control.max_layers=17", "--set", "control.scheme=smf"});
  const Json j = runs_json(said);
  Experiment e;
  const std::vector<Field> table = fields(e);
  CHECK(j.size() == table.size());
  for (const Field& f : table) {
    CAPTURE(std::string(f.key));
    REQUIRE(j.contains(std::string(f.key)));
    CHECK(j.at(std::string(f.key)).at("unit") == std::string(f.unit));
  }
  CHECK(j.at("control.max_layers").at("value") == "17");
  CHECK(j.at("control.scheme").at("value") == "\"smf\"");
}

TEST_CASE("An override that is no KEY=VALUE, or of an unknown key, is refused by its text") {
  const std::string file = kRunsSource + "/experiments/demo.toml";
  for (const char* text : {"control.scheme", "=3", "grid.nx=none", "control.schem=mpc", "grid.nx=-1"}) {
    const Said said = firn_says({"config", "check", file, "--set", text});
    CAPTURE(text, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(std::string(text).substr(0, std::string(text).find('='))));
  }
}

TEST_CASE("Committed documents are what firn config docs and firn dataflow write") {
  const std::vector<std::pair<std::vector<std::string>, std::string>> documents{
      {{"config", "docs", "-o", "-"}, "docs/configuration.md"},
      {{"config", "docs", "--machines", "-o", "-"}, "docs/machines.md"},
      {{"config", "docs", "--slice", "-o", "-"}, "docs/slice-settings.md"},
      {{"dataflow", "-o", "-"}, "docs/dataflow.md"}};
  const fs::path file = fresh_folder("docs") / "written.md";
  for (auto [words, path] : documents) {
    const Said said = firn_says(words);
    CHECK(said.code == 0);
    CHECK(!said.out.empty());
    words.back() = file.string();
    words.push_back("--json");
    if (words.front() == "dataflow") continue;
    const Json j = runs_json(firn_says(words));
    CHECK(j.at("written") == file.string());
    CHECK(j.at("bytes") == said.out.size());
    CHECK(file_text(file) == said.out);
  }
}

TEST_CASE("firn dataflow --json has each channel once, with publishers and a known delivery") {
  std::set<std::string> seen;
  for (const Json& row : runs_json(firn_says({"dataflow", "--json"}))) {
    CHECK(seen.insert(row.at("channel")).second);
    CHECK((row.at("delivery") == "reliable" || row.at("delivery") == "latest"));
    CHECK(row.at("publishers").is_array());
    CHECK(row.at("subscribers").is_array());
    CHECK(!row.at("type").get<std::string>().empty());
  }
  CHECK(seen.contains("LAYER_PLAN"));
  CHECK(seen.contains("HEIGHT_MAP"));
}

TEST_CASE("firn audit of a recorded run is clean, and its droplets balance") {
  for (const std::string& name : kRuns) {
    const Said said = firn_says({"audit", golden(name).string(), "--json"});
    const Json j = runs_json(said);
    CAPTURE(name, said.out);
    CHECK(said.code == 0);
    CHECK(j.at("clean") == true);
    CHECK(j.at("finished") == true);
    CHECK(j.at("violations").empty());
    const auto of = [&](const char* key) { return j.at(key).get<std::int64_t>(); };
    CHECK(of("triggered") == of("fired") + of("missed") + of("ignored"));
    CHECK(of("commanded") <= of("triggered"));
    const Said words = firn_says({"audit", golden(name).string()});
    CHECK(words.out.rfind("clean: ", 0) == 0);
  }
}

TEST_CASE("An audit of a run whose record of a node was cut is not clean, and tells what it lacks") {
  const fs::path run = golden_copy("v1-mpc", "audit-cut");
  const fs::path wal = run / "nodes" / "stage.wal";
  fs::resize_file(wal, fs::file_size(wal) / 2);
  const Said said = firn_says({"audit", run.string(), "--json"});
  const Json j = runs_json(said);
  CHECK(said.code == 1);
  CHECK(j.at("clean") == false);
  CHECK(j.at("violations_total").get<int>() >= int(j.at("violations").size()));
  CHECK(!j.at("violations").empty());
}

TEST_CASE("Commands that need a run folder refuse another folder by its name with exit code 2") {
  const fs::path empty = fresh_folder("no-run");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"audit"}, {"replay"}, {"report"}, {"identify"}, {"calibrate"}})
    for (const fs::path& path : {empty, empty / "nowhere"}) {
      std::vector<std::string> all = words;
      all.push_back(path.string());
      if (words[0] == "report") all.insert(all.end(), {"-o", (empty / "r.html").string()});
      const Said said = firn_says(all);
      CAPTURE(words[0], path.string(), said.err, said.out);
      CHECK(said.code == 2);
      CHECK_THAT(said.err, Contains(path.string()));
      CHECK(said.out.empty());
    }
  CHECK(fs::is_empty(empty));
}

TEST_CASE(
    "firn replay of a recorded run is identical, and compares every message of the log that a node sent") {
  const Said said = firn_says({"replay", golden("v1.0-mpc").string(), "--json"});
  const Json j = runs_json(said);
  CHECK(said.code == 0);
  CHECK(j.at("identical") == true);
  CHECK(j.at("findings_total") == 0);
  CHECK(j.at("nodes").size() >= 8);
  std::int64_t sent = 0;
  for (const Json& node : j.at("nodes")) sent += node.at("messages").get<std::int64_t>();
  CHECK(j.at("log_messages").get<std::int64_t>() <= sent);
  CHECK(j.at("log_messages").get<std::int64_t>() > 0);
}

TEST_CASE(
    "Commands that learn from a run refuse one that is not as it was sealed, and take it with a warning") {
  const fs::path root = fresh_folder("unsealed");
  const Said printed = firn_says({"print", kRunsSource + "/experiments/excitation.toml", "--bus",
                                  "in-process", "--set", "part.height_mm=0.03", "--runs", root.string()});
  CAPTURE(printed.err);
  fs::path run;
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.is_directory()) run = entry.path();
  REQUIRE_FALSE(run.empty());
  std::ofstream(run / "experiment.toml", std::ios::app) << "# one line more\n";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"identify"}, {"tune", "smf"}, {"calibrate"}, {"identify", "--spacing"}}) {
    std::vector<std::string> all = words;
    all.push_back(run.string());
    const Said refused = firn_says(all);
    CAPTURE(words, refused.err);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("experiment.toml: bytes") && Contains("--unsealed"));
    all.push_back("--unsealed");
    CHECK_THAT(firn_says(all).err, Contains("experiment.toml: bytes") && !Contains("not as it was sealed"));
  }
}

TEST_CASE("firn replay with another gain differs, exits 1 and names setting, node and field") {
  const Said said =
      firn_says({"replay", golden("v1.0-smf-resumed").string(), "--json", "--set", "control.smf.kp=0.1"});
  const Json j = runs_json(said);
  CHECK(said.code == 1);
  CHECK(j.at("identical") == false);
  CHECK_THAT(j.at("changed_settings").at(0).get<std::string>(), Contains("control.smf.kp"));
  CHECK_THAT(j.at("notes").dump(), Contains("not what would have been printed") && Contains("firn tune"));
  const Json& first = j.at("findings").at(0);
  CHECK(first.at("node") == "controller");
  CHECK(first.at("channel") == "LAYER_PLAN");
  CHECK(!first.at("field").get<std::string>().empty());
  const Said words =
      firn_says({"replay", golden("v1.0-smf-resumed").string(), "--set", "control.smf.kp=0.1"});
  CHECK_THAT(words.out, Contains("first divergence") && Contains("changed setting: control.smf.kp"));
}

TEST_CASE("firn replay refuses what it cannot use: tolerances, ignores, nodes and settings") {
  const std::string run = golden("v1-mpc").string();
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--tolerance", "-1"}, "--tolerance"},
      {{"--tolerance", "nan"}, "--tolerance"},
      {{"--ignore", "iterations"}, "FIELD=reason"},
      {{"--node", "controler"}, "controler"},
      {{"--set", "control.nothing=1"}, "control.nothing"},
      {{"--threads", "5000"}, "5000"}};
  for (const auto& [more, named] : cases) {
    std::vector<std::string> words{"replay", run};
    words.insert(words.end(), more.begin(), more.end());
    const Said said = firn_says(words);
    CAPTURE(more[0], more[1], said.err, said.out);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(named));
  }
}

TEST_CASE("firn report writes one page and a metrics.csv with a line for each layer") {
  const fs::path run = golden_copy("v1-mpc", "report");
  const fs::path page = run.parent_path() / "page.html";
  const Said said = firn_says({"report", run.string(), "-o", page.string(), "--no-replay", "--json"});
  const Json j = runs_json(said);
  CHECK(said.code == 0);
  CHECK(j.at("report") == page.string());
  CHECK(j.at("runs") == Json{run.string()});
  const std::string html = file_text(page);
  CHECK(html.rfind("<!doctype html>", 0) == 0);
  CHECK(html.find("</html>") != html.npos);
  const std::size_t layers = Json::parse(file_text(run / "result.json")).at("layers");
  CHECK(lines_of(file_text(run / "metrics.csv")).size() == layers + 2);  // head, and the bare substrate
}

TEST_CASE("A report that cannot be written leaves an older page as it was") {
  const fs::path run = golden_copy("v1-mpc", "report-fails");
  const fs::path page = run.parent_path() / "page.html";
  write_file_text(page, "old");
  CHECK(firn_says({"report", run.string(), (run / "nowhere").string(), "-o", page.string(), "--no-replay"})
            .code == 2);
  CHECK(file_text(page) == "old");
  const Said said = firn_says({"report", run.string(), "-o", "/nonexistent/r.html", "--no-replay"});
  CHECK(said.code != 0);
  CHECK_THAT(said.err, Contains("/nonexistent/r.html"));
}

TEST_CASE("firn log verify finds every file of a recorded run whole, and counts what firn log cat prints") {
  for (const std::string& name : kRuns)
    for (const fs::path& file :
         {golden(name) / "log.lcm", golden(name) / "nodes" / "scheduler.wal", golden(name) / "world.rec"}) {
      const Said said = firn_says({"log", "verify", file.string(), "--json"});
      const Json j = runs_json(said);
      CAPTURE(file.string(), said.out);
      CHECK(said.code == 0);
      CHECK(j.at("ok") == true);
      CHECK(j.at("bytes") == fs::file_size(file));
      CHECK(j.at("lost") == 0);
      if (name != "v1-mpc") continue;
      const auto lines = lines_of(firn_says({"log", "cat", file.string()}).out);
      CHECK(lines.size() == j.at("read").get<std::size_t>());
    }
}

TEST_CASE("Each line of firn log cat is a JSON object, and channels part the lines of a log") {
  const std::string log = (golden("v3-kalman") / "log.lcm").string();
  std::map<std::string, std::size_t> by_channel;
  std::int64_t before = -1;
  const auto lines = lines_of(firn_says({"log", "cat", log}).out);
  for (const std::string& line : lines) {
    const Json j = Json::parse(line);
    ++by_channel[j.at("channel")];
    CHECK(j.at("event").get<std::int64_t>() > before);
    before = j.at("event");
    CHECK(j.contains("message"));
  }
  std::size_t sum = 0;
  for (const auto& [channel, count] : by_channel)
    sum += lines_of(firn_says({"log", "cat", log, "-c", channel}).out).size();
  CHECK(sum == lines.size());
  const Json verified = runs_json(firn_says({"log", "verify", log, "--json"}));
  for (const auto& [channel, count] : by_channel)
    CHECK(verified.at("channels").at(channel).at("messages") == count);
}

TEST_CASE("Times cut a log into parts that make up the whole, and a count its beginning") {
  const std::string log = (golden("v1-mpc") / "log.lcm").string();
  const auto all = lines_of(firn_says({"log", "cat", log}).out);
  std::vector<std::int64_t> times;
  for (const std::string& line : all) times.push_back(Json::parse(line).at("utime_us"));
  const std::int64_t cut = times[times.size() / 2];
  const std::string at = std::to_string(double(cut) * 1e-6 + 4e-7),
                    after = std::to_string(double(cut) * 1e-6 + 6e-7);
  const auto first = lines_of(firn_says({"log", "cat", log, "--to", at}).out),
             second = lines_of(firn_says({"log", "cat", log, "--from", after}).out);
  const auto early = [&](std::int64_t t) { return t <= cut; };
  CHECK(std::ptrdiff_t(first.size()) == std::count_if(times.begin(), times.end(), early));
  CHECK(first.size() + second.size() == all.size());
  for (const int count : {0, 1, 7})
    CHECK(lines_of(firn_says({"log", "cat", log, "-n", std::to_string(count)}).out).size() ==
          std::size_t(count));
  CHECK(lines_of(firn_says({"log", "cat", log, "-n", "100000"}).out).size() == all.size());
}

TEST_CASE("firn log cat --full prints whole arrays where it shortens them else") {
  const std::string log = (golden("v1-mpc") / "log.lcm").string();
  const Json shortened = Json::parse(
                 lines_of(firn_says({"log", "cat", log, "-c", "HEIGHT_MAP", "-n", "1"}).out).at(0)),
             whole = Json::parse(
                 lines_of(firn_says({"log", "cat", log, "-c", "HEIGHT_MAP", "-n", "1", "--full"}).out).at(0));
  const std::size_t n = whole.at("message").at("n");
  CHECK(whole.at("message").at("height_mm").size() == n);
  CHECK(shortened.at("message").at("height_mm").at("count") == n);
  for (std::size_t c = 0; c < 8; ++c)
    CHECK(shortened.at("message").at("height_mm").at("first").at(c) ==
          whole.at("message").at("height_mm").at(c));
}

TEST_CASE("A log cut anywhere is repaired to the events of the whole one") {
  const fs::path run = golden_copy("v1-mpc", "repair");
  const fs::path log = run / "log.lcm";
  const std::string whole = file_text(log);
  const std::size_t events = runs_json(firn_says({"log", "verify", log.string(), "--json"})).at("read");
  RandomStream random(72, Purpose::kTest);
  for (int trial = 0; trial < 3; ++trial) {
    const std::size_t keep = whole.size() / 4 + random.below(std::uint32_t(whole.size() / 2));
    write_file_text(log, whole.substr(0, keep));
    fs::remove(run / "log.lcm.idx");
    const Said said = firn_says({"log", "repair", log.string(), "--json"});
    const Json j = runs_json(said);
    CAPTURE(keep, said.out);
    CHECK(j.at("rewritten") == true);
    CHECK(j.at("inserted").get<std::int64_t>() > 0);
    const Json after = runs_json(firn_says({"log", "verify", log.string(), "--json"}));
    CHECK(after.at("problem_count") == 0);
    CHECK(after.at("lost") == 0);
    CHECK(after.at("read").get<std::size_t>() <= events);
    const Json again = runs_json(firn_says({"log", "repair", log.string(), "--json"}));
    CHECK(again.at("rewritten") == false);
  }
}

TEST_CASE("A flipped bit in a log or in a node's file is found by its byte") {
  for (const char* name : {"log.lcm", "nodes/controller.wal", "world.rec"}) {
    const fs::path run = golden_copy("v1-mpc", "flip");
    const fs::path file = run / name;
    const std::string whole = file_text(file);
    RandomStream random(73, Purpose::kTest);
    for (int trial = 0; trial < 5; ++trial) {
      std::string bytes = whole;
      const std::size_t at = 200 + random.below(std::uint32_t(bytes.size() - 400));
      bytes[at] = char(bytes[at] ^ 4);
      write_file_text(file, bytes);
      const Said said = firn_says({"log", "verify", file.string(), "--json"});
      const Json j = runs_json(said);
      CAPTURE(name, at, said.out);
      CHECK(said.code == 1);
      CHECK(j.at("ok") == false);
      CHECK(j.at("damage_count").get<int>() + j.at("problem_count").get<int>() > 0);
      for (const Json& d : j.at("damage")) CHECK(d.at("offset").get<std::size_t>() <= at);
    }
  }
}

TEST_CASE("Files that firn log cannot read are refused by name: missing, a folder, empty") {
  const fs::path folder = fresh_folder("log-none");
  write_file_text(folder / "empty.wal", "");
  for (const char* verb : {"verify", "cat", "repair"})
    for (const fs::path& file : {folder / "none.lcm", folder}) {
      const Said said = firn_says({"log", verb, file.string()});
      CAPTURE(verb, file.string(), said.err);
      CHECK(said.code == 2);
      CHECK_THAT(said.err, Contains(file.string()));
    }
  const Json empty = runs_json(firn_says({"log", "verify", (folder / "empty.wal").string(), "--json"}));
  CHECK(empty.at("read") == 0);
  CHECK(empty.at("bytes") == 0);
}

TEST_CASE("firn doctor's exit code is what its checks say, and every fault has its mend") {
  const Said said = firn_says({"doctor", "--json"});
  const Json j = runs_json(said);
  bool well = true;
  for (const Json& check : j.at("checks")) {
    well = well && check.at("ok").get<bool>();
    CHECK(!check.at("found").get<std::string>().empty());
    CHECK(check.at("mend").get<std::string>().empty() == check.at("ok").get<bool>());
  }
  CHECK(j.at("well") == well);
  CHECK(said.code == (well ? 0 : 1));
  const Said words = firn_says({"doctor"});
  CHECK(words.code == said.code);
  for (const Json& check : j.at("checks"))
    CHECK_THAT(words.out, Contains(check.at("check").get<std::string>()));
}

TEST_CASE("firn doctor names the port that refuses, once, and why") {
  const fs::path lab = fresh_folder("doctor-ports") / "lab.toml";
  const std::string address = "tcp:127.0.0.1:1";  // nobody serves it
  std::ofstream(lab) << "include = \"" << FIRN_SOURCE_DIR
                     << "/labs/inkjet-lu2015.toml\"\n[devices]\nlamp.port = \"" << address << "\"\n";
  const Json j = runs_json(firn_says({"doctor", lab.string(), "--json"}));
  std::string found;
  for (const Json& check : j.at("checks"))
    if (check.at("check") == "lamp" && !check.at("ok").get<bool>()) found = check.at("found");
  CHECK(found == address + ": Connection refused");
}

TEST_CASE("Tuned gains are stable and no worse than where they started or than the thesis' own") {
  for (const char* algorithm : {"slsqp", "lbfgs", "cobyla"}) {
    const Json j = runs_json(firn_says({"tune", "smf", "--json", "--algorithm", algorithm, "--intervals",
                                        "30", "--pulse-at", "5", "--step-at", "15", "--random", "0.05"}));
    CHECK(j.at("intervals") == 30);
    REQUIRE(j.at("disturbance").size() == 30);
    const Json& gains = j.at("gains");
    REQUIRE(gains.size() == 2);
    CAPTURE(algorithm, gains.dump());
    const double tuned = gains.at(0).at("rms_intervals"), thesis = gains.at(1).at("rms_intervals");
    CHECK(tuned > 0.0);
    CHECK(tuned <= thesis * 1.001);
    CHECK(gains.at(0).at("stable") == true);
    CHECK(gains.at(0).at("largest_pole").get<double>() < 1.0);
  }
}

TEST_CASE("The disturbance that firn tune smf draws is the one that was asked for") {
  const Json j = runs_json(firn_says({"tune", "smf", "--json", "--intervals", "12", "--pulse", "0.5",
                                      "--pulse-at", "4", "--step", "0.25", "--step-at", "8"}));
  const std::vector<double> d = j.at("disturbance");
  REQUIRE(d.size() == 12);
  double sum = 0.0;
  for (const double v : d) sum += v;
  CHECK(sum == Approx(0.5 + 0.25 * double(std::count(d.begin(), d.end(), 0.25))));
  CHECK(std::count(d.begin(), d.end(), 0.5) + std::count(d.begin(), d.end(), 0.75) == 1);
  const int steps = int(std::count(d.begin(), d.end(), 0.25));
  CHECK(steps >= 4);
  CHECK(steps <= 5);
}

TEST_CASE("firn tune smf says what its model leaves out and where whole prints are predicted") {
  const Said said = firn_says({"tune", "smf"});
  CHECK(said.code == 0);
  CHECK_THAT(said.out, Contains("neighbours") && Contains("firn tune RUN --keys"));
}

TEST_CASE("firn tune names a missing run, a key, a range and a goal that are not usable") {
  const std::string run = golden("v1-smf-resumed").string();
  const auto refused = [&](const std::vector<std::string>& words) {
    const Said said = firn_says(words);
    CAPTURE(words, said.out);
    CHECK(said.code == 2);
    return said.err;
  };
  CHECK_THAT(refused({"tune", "--keys", "control.smf.kp"}), Contains("a run is wanted"));
  CHECK_THAT(refused({"tune", run, "--keys", "control.smf.kp", "--goal", "beauty"}),
             Contains("beauty") && Contains("rms_um"));
  CHECK_THAT(refused({"tune", "/nonexistent", "--keys", "control.smf.kp"}), Contains("/nonexistent"));
}

TEST_CASE("firn tune smf writes a picture of error and action") {
  const fs::path file = fresh_folder("tune") / "smf.svg";
  CHECK(firn_says({"tune", "smf", "-o", file.string()}).code == 0);
  const std::string svg = file_text(file);
  CHECK(svg.rfind("<svg", 0) == 0);
  CHECK(svg.find("</svg>") != svg.npos);
  CHECK(firn_says({"tune", "smf", "-o", "/nonexistent/x.svg"}).code != 0);
}

}  // namespace
}  // namespace firn::test
