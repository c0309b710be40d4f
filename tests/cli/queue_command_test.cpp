// firn queue: prints that wait for a lab, and the fate of one that stops, is refused or was changed.
#include <algorithm>
#include <catch2/catch.hpp>

#include "files/exit_codes.h"
#include "files/json.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

using Catch::Contains;
namespace fs = std::filesystem;

/// A folder of runs with a queue, and an experiment of its own that is small.
struct WaitingPrints {
  explicit WaitingPrints(const std::string& name) : folder(fresh_folder("queue-" + name)) {
    std::string text = file_text(FIRN_SOURCE_DIR "/experiments/cuboid.toml");
    const std::size_t at = text.find("../labs");
    text.replace(at, 7, FIRN_SOURCE_DIR "/labs");
    write_file_text(experiment(), text);
  }
  fs::path experiment() const { return folder / "part.toml"; }
  fs::path runs() const { return folder / "runs"; }
  std::string queue_text() const { return file_text(runs() / "queue.json"); }

  Said says(std::vector<std::string> words) const {
    words.insert(words.begin(), "queue");
    words.insert(words.end(), {"--runs", runs().string()});
    return firn_says(words);
  }
  Said add(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"add",   experiment().string(), "--bus", "in-process",
                                   "--set", "part.height_mm=0.01", "--by",  "Ada"};
    words.insert(words.end(), more.begin(), more.end());
    return says(words);
  }
  nlohmann::json list() const { return nlohmann::json::parse(says({"list", "--json"}).out); }
  std::vector<int> ids() const {
    std::vector<int> all;
    const nlohmann::json told = list();
    for (const auto& p : told["prints"]) all.push_back(p["id"]);
    return all;
  }
  int folders() const {
    if (!fs::exists(runs())) return 0;
    return int(std::ranges::count_if(fs::directory_iterator(runs()),
                                     [](const fs::directory_entry& e) { return e.is_directory(); }));
  }

  fs::path folder;
};

}  // namespace

TEST_CASE("firn queue add names a mistake of the experiment at once, and leaves the queue as it was") {
  const WaitingPrints q("mistakes");
  REQUIRE(q.add().code == kOk);
  const std::string before = q.queue_text();
  const auto refused = [&](const std::vector<std::string>& words, const std::string& why) {
    const Said said = q.says(words);
    CAPTURE(said.err);
    CHECK(said.code == kUsage);
    CHECK_THAT(said.err, Contains(why));
    CHECK(q.queue_text() == before);
  };
  const std::string file = q.experiment().string();
  refused({"add", file, "--set", "part.height_mm=-1"}, "part.height_mm");
  refused({"add", file, "--set", "part.hight_mm=1"}, "hight_mm");
  refused({"add", (q.folder / "nosuch.toml").string()}, "nosuch.toml");
  refused({"add", file, "--set", "part.shape=height_map"}, "image");
  refused({"add", file, "--bus", "nonsense"}, "nonsense");
  refused({"remove", "7"}, "has no print 7");
}

TEST_CASE("firn queue list tells what waits, who added it, and who says that the bed is clear") {
  const WaitingPrints q("list");
  CHECK_THAT(q.says({"list"}).out, Contains("no print waits"));
  REQUIRE(q.add({"--meta", "sample=A7"}).code == kOk);
  REQUIRE(q.says({"clear", "--by", "Bo"}).code == kOk);
  const std::string text = q.says({"list"}).out;
  CHECK_THAT(text, Contains("part.toml --set part.height_mm=0.01 --meta sample=A7  (waits, added by Ada)"));
  CHECK_THAT(text, Contains("the bed is clear, says Bo"));
  const nlohmann::json j = q.list();
  CHECK(j["bed_cleared_by"] == "Bo");
  CHECK(j["prints"][0]["meta"] == nlohmann::json({"sample=A7"}));
  CHECK(j["prints"][0]["state"] == "waits");
}

TEST_CASE("A print that is added first goes before all that wait, and one that is removed is gone") {
  const WaitingPrints q("order");
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {}, {"--first"}})
    REQUIRE(q.add(more).code == kOk);
  CHECK(q.ids() == std::vector<int>{3, 1, 2});
  CHECK(q.says({"remove", "1"}).code == kOk);
  CHECK(q.ids() == std::vector<int>{3, 2});
}

TEST_CASE("A print that stops ends the queue's work and stays first until a person has finished it") {
  const WaitingPrints q("stops");
  REQUIRE(q.add({"--set", "control.max_layers=1"}).code == kOk);
  REQUIRE(q.add().code == kOk);
  REQUIRE(q.says({"clear"}).code == kOk);
  CHECK(q.says({"start"}).code == kSafetyStop);
  const nlohmann::json first = q.list()["prints"][0];
  CHECK(first["state"] == "stopped");
  CHECK_THAT(std::string(first["why"]), Contains("max_layers"));
  const std::string run = first["run"];
  REQUIRE(q.says({"clear"}).code == kOk);
  const Said again = q.says({"start"});
  CHECK(again.code == kUsage);
  CHECK_THAT(again.err, Contains("print --resume " + run) && Contains("firn queue remove 1"));
  CHECK(q.folders() == 1);
  REQUIRE(
      firn_says({"print", "--resume", run, "--bus", "in-process", "--set", "control.max_layers=60"}).code ==
      kOk);
  CHECK(q.says({"start"}).code == kOk);
  CHECK(q.ids().empty());
  CHECK(q.folders() == 2);
}

TEST_CASE("A print out of tolerance leaves the queue, which goes on and tells the worst of the ends") {
  const WaitingPrints q("tolerance");
  REQUIRE(q.add({"--tolerance", "0.001"}).code == kOk);
  REQUIRE(q.says({"clear", "--by", "Bo"}).code == kOk);
  CHECK(q.says({"start"}).code == kOutOfTolerance);
  CHECK(q.ids().empty());
  CHECK(q.folders() == 1);
  CHECK(q.list()["bed_cleared_by"] == "");  // the word is spent
}

TEST_CASE("An experiment that was changed after it was queued is refused, and the bed stays clear") {
  const WaitingPrints q("changed");
  REQUIRE(q.add().code == kOk);
  write_file_text(q.experiment(), file_text(q.experiment()) + "# more\n");
  REQUIRE(q.says({"clear", "--by", "Bo"}).code == kOk);
  const Said said = q.says({"start"});
  CHECK(said.code == kUsage);
  CHECK_THAT(said.err, Contains("part.toml") && Contains("not as it was when it was queued"));
  CHECK(q.folders() == 0);
  CHECK(q.list()["bed_cleared_by"] == "Bo");
}

TEST_CASE("A print that is refused when its turn comes waits again, and the bed stays as clear as it was") {
  const WaitingPrints q("refused");
  const fs::path picture = q.folder / "part.png";
  fs::copy_file(FIRN_SOURCE_DIR "/experiments/height_map.png", picture);
  REQUIRE(q.add({"--set", "part.shape=height_map", "--set", "part.image=" + picture.string(), "--set",
                 "part.image_white_mm=0.02", "--set", "part.depth_mm=8"})
              .code == kOk);
  fs::remove(picture);
  REQUIRE(q.says({"clear", "--by", "Bo"}).code == kOk);
  const Said said = q.says({"start"});
  CHECK(said.code == kUsage);
  CHECK_THAT(said.err, Contains("part.png"));
  CHECK(q.list()["prints"][0]["state"] == "waits");
  CHECK(q.list()["bed_cleared_by"] == "Bo");
  CHECK(q.folders() == 0);
}

TEST_CASE("A queue that is damaged is named, and stays as it is") {
  const WaitingPrints q("damaged");
  fs::create_directories(q.runs());
  for (const std::string text :
       {"", "[]", "{", "{\"version\": 2}", "{\"version\": 1, \"prints\": [{\"id\": \"x\"}]}", "\x01\x02"}) {
    write_file_text(q.runs() / "queue.json", text);
    for (const Said& said : {q.says({"list"}), q.says({"clear"}), q.says({"start"}), q.add()}) {
      CHECK(said.code == kUsage);
      CHECK_THAT(said.err, Contains("queue.json"));
    }
    CHECK(q.queue_text() == text);
  }
}

}  // namespace firn::test
