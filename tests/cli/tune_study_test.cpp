// The pairs of prints of firn tune --verify as a study: settings that are remembered, shards, state.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "cli/make_study.h"
#include "cli/tune_pairs.h"
#include "files/exit_codes.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "studies/compare/study_shards.h"
#include "studies/tune/tune_keys.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

// A cuboid of six layers under SMF.
fs::path small_print(const std::string& name) {
  const fs::path root = fresh_folder(name);
  std::vector<std::string> words{"print",  std::string(FIRN_SOURCE_DIR) + "/experiments/demo.toml",
                                 "--bus",  "in-process",
                                 "--runs", root.string()};
  for (const char* set : {"grid.nx=14", "grid.ny=12", "part.shape=cuboid", "part.width_mm=2.6",
                          "part.depth_mm=2.1", "part.height_mm=0.055", "control.scheme=smf",
                          "laser_profiler.points=64", "process.scan_speed_mm_s=15.0"})
    words.insert(words.end(), {"--set", set});
  const Said said = firn_says(words);
  CAPTURE(said.err);
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.is_directory()) return entry.path();
  FAIL("no run");
  return {};
}

// A command whose search is over: the folder remembers its answer.
struct Searched {
  explicit Searched(const std::string& name) : run(small_print(name)) {
    options.runs = {run.string()};
    options.keys = {"control.smf.kp"};
    options.verify = 3;
    options.study.output = (run.parent_path() / "pairs").string();
    options.study.threads = 1;
    runs.push_back(tune::RecordedRun::read(run));
    keys.emplace_back("control.smf.kp", runs[0].experiment);
  }
  TunedRuns tuned() const { return {options, runs, runs[0], keys}; }
  tune::PairSettings settings() const { return {{1.0}, {0.7}, options.verify, options.seed}; }
  std::size_t lines() const {
    std::size_t all = 0;
    for (const fs::path& journal : shard_journals(options.study.output)) {
      std::ifstream in(journal);
      for (std::string line; std::getline(in, line);) ++all;
    }
    return all;
  }

  fs::path run;
  TuneLabOptions options;
  std::vector<tune::RecordedRun> runs;
  std::vector<tune::TuneKey> keys;
};

}  // namespace

TEST_CASE("shards of a promise's pairs search nothing, print each pair once, and say what one piece says") {
  Searched s("tune-pairs");
  remember_settings(s.tuned(), s.settings());
  TuneLabOptions shard = s.options;
  for (const char* k : {"1/2", "2/2"}) {
    shard.study.shard = k;
    CHECK(run_tune_lab(shard) == kOk);
  }
  CHECK(s.lines() == 6);
  const tune::PromisePairs pairs(s.runs[0], s.keys, s.settings());
  const tune::Promise promise;
  const StudyEnd merged = make_study(s.options.study, pairs, {});
  StudyOptions in_memory;
  in_memory.threads = 1;
  const StudyEnd whole = make_study(in_memory, pairs, {});
  REQUIRE(merged.journal);
  REQUIRE(whole.journal);
  const auto a = tune::verification_of(pairs, *merged.journal, promise, 0),
             b = tune::verification_of(pairs, *whole.journal, promise, 0);
  CHECK(a.pairs.difference == b.pairs.difference);
  CHECK(a.pairs.interval.low == b.pairs.interval.low);
  CHECK(a.stopped_new == b.stopped_new);
}

TEST_CASE("settings are remembered for the same question alone") {
  Searched s("tune-question");
  CHECK_FALSE(remembered_settings(s.tuned()));
  remember_settings(s.tuned(), s.settings());
  const auto found = remembered_settings(s.tuned());
  REQUIRE(found);
  CHECK(found->new_setting == tune::Setting{0.7});
  CHECK(found->pairs == 3);
  s.options.goal = "std";
  CHECK_FALSE(remembered_settings(s.tuned()));
  s.options.goal = "rms";
  s.options.budget = 500;
  CHECK_FALSE(remembered_settings(s.tuned()));
  std::ofstream(fs::path(s.options.study.output) / "settings.json") << "[]";
  CHECK_THROWS_WITH(remembered_settings(s.tuned()), Contains("settings.json") && Contains("no record"));
}

TEST_CASE("the state of a promise's pairs is told of a folder that remembers settings, else refused") {
  Searched s("tune-state");
  s.options.study.status = true;
  CHECK_THROWS_WITH(run_tune_lab(s.options), Contains("--status") && Contains("remembers no settings"));
  remember_settings(s.tuned(), s.settings());
  CHECK(run_tune_lab(s.options) == kOk);
  CHECK(s.lines() == 0);
}

TEST_CASE("options of a study are refused where firn tune has no folder or no pairs for them") {
  TuneLabOptions o;
  o.runs = {"run"};
  o.keys = {"control.smf.kp"};
  o.study.shard = "1/2";
  CHECK_THROWS_WITH(run_tune_lab(o), Contains("--shard") && Contains("--study"));
  o.study.shard.clear();
  o.study.output = "pairs";
  CHECK_THROWS_WITH(run_tune_lab(o), Contains("--study") && Contains("--verify"));
}

TEST_CASE("the command of a shard names all that decides the settings, and paths from the root") {
  TuneLabOptions o;
  o.runs = {"runs/a"};
  o.keys = {"control.smf.kp=0.2:2", "control.smf.ki_star"};
  o.overrides = {"control.scheme=smf"};
  o.verify = 7;
  o.study.output = "pairs";
  const std::vector<std::string> words = pair_words(o);
  const auto after = [&](const std::string& option) {
    const auto at = std::ranges::find(words, option);
    return at == words.end() || at + 1 == words.end() ? std::string() : *(at + 1);
  };
  CHECK(fs::path(words[2]).is_absolute());
  CHECK(after("--keys") == "control.smf.kp=0.2:2,control.smf.ki_star");
  CHECK(after("--set") == "control.scheme=smf");
  CHECK(after("--verify") == "7");
  CHECK(fs::path(after("--study")).is_absolute());
}

}  // namespace firn::test
