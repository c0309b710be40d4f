// Commands over files that are damaged, missing or of another kind: the user reads one line in Firn's words
// with the file's name, never an exception of a library.
#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;

// A way to damage the file or folder at `path`.
struct Damage {
  const char* name;
  void (*apply)(const fs::path& path);
  bool json_only = false;
};

void as_text(const fs::path& path, const std::string& text) {
  fs::remove_all(path);
  write_file_text(path, text);
}

const Damage kDamages[] = {
    {"missing", [](const fs::path& p) { fs::remove_all(p); }},
    {"empty", [](const fs::path& p) { as_text(p, ""); }},
    {"a folder",
     [](const fs::path& p) {
       fs::remove_all(p);
       fs::create_directory(p);
     }},
    {"a dangling link",
     [](const fs::path& p) {
       fs::remove_all(p);
       fs::create_symlink("nowhere", p);
     }},
    {"a link to itself",
     [](const fs::path& p) {
       fs::remove_all(p);
       fs::create_symlink(p.filename(), p);
     }},
    {"cut",
     [](const fs::path& p) {
       const std::string whole = fs::is_regular_file(p) ? file_text(p) : "";
       as_text(p, whole.substr(0, whole.size() / 2));
     }},
    {"zeros", [](const fs::path& p) { as_text(p, std::string(300, '\0')); }},
    {"a list", [](const fs::path& p) { as_text(p, "[]"); }, true},
    {"null", [](const fs::path& p) { as_text(p, "null"); }, true},
    {"nested deep", [](const fs::path& p) { as_text(p, std::string(100'000, '[')); }, true},
    {"no UTF-8", [](const fs::path& p) { as_text(p, "{\"\xff\": \"\xc0\x80\"}"); }, true},
    {"of other types",
     [](const fs::path& p) {
       as_text(p, R"({"run_id": 1e300, "inputs": [[1]], "scheme": {}, "command_line": 4, "outcome": 1,
                      "status": "x", "layers": 1e99, "reason": null})");
     },
     true},
    {"of numbers beyond 64 bits",
     [](const fs::path& p) {
       as_text(p, R"({"run_id": 18446744073709551615, "inputs": [], "outcome": "", "status": 99999999999,
                      "layers": -1, "reason": ""})");
     },
     true},
};

const char* const kForeign[] = {
    "json.exception", "filesystem error", "basic_", "vector::", "std::",    "stoi",
    "what()",         "map::at",          "ios_",   "iostream", "bad_alloc"};

void check_words(const Said& said) {
  CHECK((said.code == 0 || said.code == 1 || said.code == 2));
  for (const char* foreign : kForeign) {
    CHECK(said.err.find(foreign) == said.err.npos);
    CHECK(said.out.find(foreign) == said.out.npos);
  }
}

// A folder's name stands in every error that concerns a file in it.
void check_failure(const Said& said, const fs::path& folder) {
  check_words(said);
  if (said.code != 2 || said.err.empty()) return;  // a verdict stands on stdout
  CHECK(said.err.find('\n') == said.err.npos);
  CHECK(said.err.find(folder.filename().string()) != said.err.npos);
}

std::vector<std::vector<std::string>> commands_on(const fs::path& run) {
  const std::string r = run.string(), page = (run.parent_path() / "page.html").string();
  return {{"audit", r},
          {"replay", r},
          {"report", "--no-replay", r, "-o", page},
          {"identify", r},
          {"calibrate", r},
          {"tune", "smf", r},
          {"spy", r},
          {"print", "--resume", r, "--bus", "in-process"},
          {"log", "verify", (run / "log.lcm").string()},
          {"log", "cat", (run / "nodes" / "controller.wal").string()},
          {"config", "check", (run / "experiment.toml").string()}};
}

TEST_CASE("Whatever is damaged in a run folder, each command answers in one line of its own words") {
  for (const char* file : {"provenance.json", "result.json", "experiment.toml", "log.lcm", "log.lcm.idx",
                           "world.rec", "world/state", "nodes/controller.wal", "nodes", "inputs"})
    for (const Damage& damage : kDamages) {
      if (damage.json_only && !std::string(file).ends_with(".json")) continue;
      const fs::path run = golden_copy("v1-mpc", "damaged-run") / "";
      const fs::path folder = run.parent_path();
      damage.apply(folder / file);
      for (const auto& words : commands_on(folder)) {
        const Said said = firn_says(words);
        CAPTURE(file, damage.name, words[0], words[1], said.code, said.err);
        check_failure(said, folder);
      }
    }
}

TEST_CASE("A metrics file that cannot be written is named by firn report") {
  for (const Damage& damage : {kDamages[2], kDamages[3]}) {
    const fs::path run = golden_copy("v1-mpc", "damaged-metrics");
    damage.apply(run / "metrics.csv");
    const Said said = firn_says({"report", "--no-replay", run.string(), "-o", (run / "page.html").string()});
    CAPTURE(damage.name, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Catch::Contains("metrics.csv"));
    check_words(said);
  }
}

TEST_CASE("Input files of another kind, or damaged, are refused by their name with exit code 2") {
  for (const Damage& damage : kDamages) {
    const fs::path folder = fresh_folder("damaged-inputs");
    for (const char* name :
         {"a.toml", "a.stl", "a.obj", "a.ply", "a.3mf", "a.json", "a.csv", "a.paths", "a.npy"})
      damage.apply(folder / name);
    const auto file = [&](const char* name) { return (folder / name).string(); };
    const std::string out = file("out.paths"), machine = std::string(FIRN_SOURCE_DIR) + "/labs/cobra600.toml";
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"slice", file("a.stl"), "-o", out},
             {"slice", file("a.obj"), "-o", out},
             {"slice", file("a.ply"), "-o", out},
             {"slice", file("a.3mf"), "-o", out},
             {"plan", file("a.json"), "-o", out, "--machine", machine},
             {"plan", file("a.csv"), "-o", out, "--machine", machine},
             {"plan", file("a.paths"), "-o", out, "--machine", machine},
             {"decide", "--height", file("a.npy"), "--target", file("a.npy")}}) {
      const Said said = firn_says(words);
      CAPTURE(damage.name, words[0], words[1], said.err);
      check_failure(said, folder);
      CHECK(said.code == 2);
      CHECK_FALSE(fs::exists(out));
    }
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"print", file("a.toml"), "--bus", "in-process", "--runs", out},
             {"config", "check", file("a.toml")},
             {"compare", file("a.toml"), "-o", out}}) {
      std::error_code error;
      if (fs::is_regular_file(folder / "a.toml", error)) continue;  // an empty experiment is one
      const Said said = firn_says(words);
      CAPTURE(damage.name, words[0], words[1], said.err, said.out);
      check_words(said);
      CHECK(said.code == 2);
    }
  }
}

TEST_CASE("Outputs that cannot be written are refused by their name with exit code 2") {
  const fs::path run = golden_copy("v1-mpc", "damaged-outputs"), folder = run.parent_path();
  write_file_text(folder / "file", "x");
  for (const char* taken : {"taken.paths", "taken.nc"}) fs::create_directory(folder / taken);
  const std::string stl = std::string(FIRN_SOURCE_DIR) + "/tests/replay/golden/tiny-ice.stl";
  for (const fs::path& out : {folder / "none" / "x.paths", folder / "file" / "x.paths",
                              folder / "taken.paths", folder / (std::string(300, 'x') + ".paths")}) {
    for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
             {"report", "--no-replay", run.string(), "-o", out.string()},
             {"slice", stl, "-o", out.string()},
             {"slice", stl, "--gcode", fs::path(out).replace_extension(".nc").string()},
             {"config", "docs", "-o", out.string()},
             {"dataflow", "-o", out.string()}}) {
      const Said said = firn_says(words);
      CAPTURE(words[0], out.string(), said.err);
      CHECK(said.code == 2);
      CHECK(said.err.find(out.stem().string().substr(0, 50)) != said.err.npos);
      check_words(said);
    }
  }
}

TEST_CASE("firn slice and firn plan write no path file whose name firn plan refuses") {
  const fs::path folder = fresh_folder("endings");
  const std::string stl = std::string(FIRN_SOURCE_DIR) + "/tests/replay/golden/tiny-ice.stl",
                    machine = std::string(FIRN_SOURCE_DIR) + "/labs/cobra600.toml";
  write_file_text(folder / "a.csv", "x_mm,y_mm\n0,0\n5,0\n");
  const auto refused = [&](const std::vector<std::string>& words, const std::string& out) {
    const Said said = firn_says(words);
    CAPTURE(words, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Catch::Contains(out + ": must end in "));
    CHECK_FALSE(fs::exists(out));
  };
  const std::string any = folder / "job.any", none = folder / "job";
  refused({"slice", stl, "-o", any}, any);
  refused({"slice", stl, "-o", none}, none);
  refused({"slice", stl, "--gcode", any}, any);
  refused({"slice", "--experiment", std::string(FIRN_SOURCE_DIR) + "/experiments/ice-small.toml", "-o", any},
          any);
  refused({"plan", folder / "a.csv", "-o", folder / "a.traj", "--machine", machine, "--gcode", any}, any);
}

TEST_CASE("A study's journal that is damaged or no file is made anew or refused by its name") {
  const std::string study =
      "seeds = 1\nexperiment = \"" + std::string(FIRN_SOURCE_DIR) +
      "/tests/replay/golden/tiny.toml\"\n[[scheme]]\nname = \"a\"\n[[scheme]]\nname = \"b\"\nset = "
      "[\"control.scheme=smf\"]\n";
  for (const Damage& damage : kDamages) {
    const fs::path folder = fresh_folder("damaged-journal");
    write_file_text(folder / "study.toml", study);
    fs::create_directory(folder / "out");
    damage.apply(folder / "out" / "results.journal");
    const Said said =
        firn_says({"compare", (folder / "study.toml").string(), "-o", (folder / "out").string()});
    CAPTURE(damage.name, said.code, said.err);
    check_words(said);
    const std::string kind = damage.name;
    if (kind == "a folder" || kind == "a link to itself") CHECK(said.code == 2);
    if (said.code == 2) CHECK_THAT(said.err, Catch::Contains("results.journal"));
  }
}

}  // namespace
}  // namespace firn::test
