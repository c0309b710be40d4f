// firn tune from the log of a small print to its answer, its page and its verification.
#include <catch2/catch.hpp>

#include <fmt/core.h>

#include <fstream>
#include <span>

#include "cli/tune_lab_command.h"
#include "files/json.h"
#include "files/record/checksum.h"
#include "files/usage_error.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Json = nlohmann::json;

const std::string kTuneSource = FIRN_SOURCE_DIR;

// A cuboid of eleven layers under SMF with an integral gain that makes it run over, in a lab of its own.
fs::path printed_run(const std::string& name) {
  const fs::path root = fresh_folder(name);
  std::vector<std::string> words{
      "print", kTuneSource + "/experiments/demo.toml", "--bus", "in-process", "--runs", root.string()};
  for (const char* set :
       {"grid.nx=14", "grid.ny=12", "part.shape=cuboid", "part.width_mm=2.6", "part.depth_mm=2.1",
        "part.height_mm=0.055", "control.scheme=smf", "control.smf.ki_star=0.6", "plant.flow=1.1",
        "plant.seed=7", "laser_profiler.points=64", "process.scan_speed_mm_s=15.0"}) {
    words.push_back("--set");
    words.push_back(set);
  }
  const Said said = firn_says(words);
  CAPTURE(said.err);
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.is_directory()) return entry.path();
  FAIL("no run");
  return {};
}

// A line with its checksum.
std::string checked_line(const std::string& text) {
  return fmt::format("{:016x} {}\n", record::checksum64(std::as_bytes(std::span(text))), text);
}

}  // namespace

TEST_CASE("firn tune answers from a print's log, writes its page and holds the promise against prints") {
  const fs::path run = printed_run("tune-lab");
  const fs::path page = run.parent_path() / "tuned.html";
  const Said said =
      firn_says({"tune", run.string(), "--keys", "control.smf.ki_star=0.01:1", "--budget", "300", "--verify",
                 "6", "--study", (run.parent_path() / "pairs").string(), "--json", "-o", page.string()});
  CAPTURE(said.out, said.err);
  const Json j = Json::parse(said.out);
  CHECK(j.at("laboratory").at("class") == "droplets");
  CHECK(j.at("check").at("passed") == true);
  const Json& advice = j.at("advice");
  CHECK(advice.at("gain_interval").at(0) <= advice.at("gain"));
  CHECK(advice.at("keys").at(0).at("key") == "control.smf.ki_star");
  const Json& verified = j.at("verification");
  CHECK(verified.at("pairs") == 6);
  const double gain = verified.at("gain");
  const bool inside = gain >= advice.at("gain_interval").at(0) && gain <= advice.at("gain_interval").at(1);
  CHECK(verified.at("held") == inside);
  CHECK(said.code == (inside ? 0 : 1));
  CHECK_THAT(file_text(page),
             Contains("</html>") && Contains("control.smf.ki_star") && Contains("plant.flow"));
  const Json settings = Json::parse(file_text(run.parent_path() / "pairs" / "settings.json"));
  CHECK(settings.at("keys") == Json{"control.smf.ki_star"});
  CHECK(settings.at("new").size() == 1);
}

TEST_CASE(
    "firn tune refuses keys that it cannot tune, pages that it cannot write and states that are none, before "
    "anything is simulated") {
  const fs::path run = printed_run("tune-refused");
  const auto refused = [&](const std::string& keys) {
    const Said said = firn_says({"tune", run.string(), "--keys", keys});
    CHECK(said.code == 2);
    CHECK(said.out.empty());
    return said.err;
  };
  CHECK_THAT(refused("control.smf.ki"), Contains("control.smf.ki_star"));
  CHECK_THAT(refused("control.smf.kpp"), Catch::EndsWith("; the nearest known one is control.smf.kp"));
  CHECK_THAT(refused("control.smf.kp,control.smf.kp"), Contains("twice"));
  CHECK_THAT(refused("control.smf.kp=3:1"), Contains("ascending"));
  const auto page_at = [&](const std::string& page) {
    return firn_says({"tune", run.string(), "--keys", "control.smf.kp", "-o", page}).err;
  };
  CHECK_THAT(page_at("/nowhere/page.html"), Contains("/nowhere/page.html") && Contains("cannot be written"));
  CHECK_THAT(page_at(run.string()), Contains("is a folder"));
  const auto state_of = [&](const std::string& text) {
    const fs::path state = run.parent_path() / "state";
    std::ofstream(state) << text;
    const Said said =
        firn_says({"tune", run.string(), "--keys", "control.smf.kp", "--state", state.string()});
    CHECK(said.code == 2);
    CHECK(file_text(state) == text);
    return said.err;
  };
  CHECK_THAT(state_of("[run]\nname = 'demo'\n"), Contains("--state") && Contains("state: line 1: damaged"));
  CHECK_THAT(state_of("9b04f9d28dfcc4d0 {\"finished\":true}\n"), Contains("line 1: damaged"));
  CHECK_THAT(state_of(checked_line("{\"digest\":\"1\",\"finished\":true}")),
             Contains("state: line 1") && Contains("key 'reason'"));
  const auto state_at = [&](const std::string& state) {
    return firn_says({"tune", run.string(), "--keys", "control.smf.kp", "--state", state}).err;
  };
  CHECK_THAT(state_at("/nowhere/state"), Contains("--state /nowhere/state: cannot be opened"));
  CHECK_THAT(state_at(run.string()), Contains("is no file"));
  const Said none = firn_says({"tune", run.string()});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Contains("--keys"));
}

TEST_CASE("firn tune refuses a gap that the nozzle needs over the part") {
  const fs::path run = printed_run("tune-gap");
  const Said said = firn_says(
      {"tune", run.string(), "--keys", "control.smf.ki_star", "--set", "process.nozzle_gap_mm=0.25"});
  CHECK(said.code == 2);
  CHECK_THAT(said.err, Contains("process.nozzle_gap_mm = 0.25: the part is 0.055 mm high"));
}

TEST_CASE("firn tune refuses a run that is not finished, by its name") {
  const fs::path run = printed_run("tune-unfinished");
  fs::remove(run / "result.json");
  TuneLabOptions o;
  o.runs = {run.string()};
  o.keys = {"control.smf.kp"};
  o.unsealed = true;
  CHECK_THROWS_WITH(run_tune_lab(o), Contains("tune-unfinished") && Contains("not finished"));
}

}  // namespace firn::test
