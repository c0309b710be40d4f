// Declarations of worlds, and studies in their labs.
#include <catch2/catch.hpp>

#include <filesystem>
#include <set>

#include "config/error.h"
#include "config/study_labs.h"
#include "tests/support/temp_folder.h"

using namespace firn;

namespace {

const std::filesystem::path kStudies = FIRN_SOURCE_DIR "/experiments/studies";

const std::string kHead =
    "metrics = [\"rms_um\"]\n[seeds]\ntuning = [1, 3]\nheld_out = [11, 14]\n[held_out]\n"
    "\"plant.drift\" = [0.1, 0.2]\n";
const std::string kWorld =
    "[[world]]\nname = \"w\"\nsource = \"s\"\n[world.tuning]\n\"plant.size_std\" = [0.0, 0.02]\n"
    "[world.held_out]\n\"plant.size_std\" = [0.02, 0.05]\n";

std::string worlds_refusal(const std::string& text) {
  try {
    parse_worlds(text, "w.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

Study study_in(const std::string& worlds, const std::string& rest, const std::string& use) {
  const test::TempFolder folder;
  folder.file("w.toml", worlds);
  return load_study(folder.file(
      "s.toml", "worlds = \"w.toml\"\nlabs = \"" + use + "\"\n" + rest + "[[scheme]]\nname = \"a\"\n"));
}

}  // namespace

TEST_CASE("The shipped worlds can be printed in every lab that they declare") {
  for (const auto& entry : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/experiments/worlds")) {
    const WorldList list = load_worlds(entry.path());
    CAPTURE(entry.path());
    for (const char* use : {"tuning", "held_out"}) {
      if (std::ranges::all_of(list.worlds, [&](const DeclaredWorld& w) {
            return w.priors[use == std::string("held_out")].empty();
          }))
        continue;
      Study s = parse_study("worlds = \"../worlds/" + entry.path().filename().string() + "\"\nlabs = \"" +
                                use + "\"\n[[scheme]]\nname = \"a\"\n",
                            "s.toml");
      take_worlds(s, kStudies);
      const std::vector<Experiment> experiments = study_experiments(s, kStudies);
      for (std::size_t part = 0; part < s.parts.size(); ++part) {
        CAPTURE(s.parts[part].name);
        CHECK_NOTHROW(check_labs(s, part, experiments[part]));
      }
    }
  }
}

TEST_CASE("No shipped world has a lab that is both for tuning and held out") {
  for (const auto& entry : std::filesystem::directory_iterator(FIRN_SOURCE_DIR "/experiments/worlds")) {
    const WorldList list = load_worlds(entry.path());
    for (const std::uint64_t seed : list.seeds[0])
      CHECK(std::ranges::find(list.seeds[1], seed) == list.seeds[1].end());
    CHECK(std::ranges::any_of(list.worlds, &DeclaredWorld::unseen));
  }
}

TEST_CASE("The shipped study of worlds is in held-out labs, and so never in one that a scheme was tuned in") {
  const Study s = load_study(kStudies / "worlds.toml");
  CHECK(s.parts.size() == 10);
  CHECK(s.seeds.size() == 80);
  CHECK(s.seeds.front() == 1001);
  CHECK(!s.worlds.goals.empty());
  for (const StudyEntry& world : s.parts) CHECK(!world.source.empty());
}

TEST_CASE("Worlds are a study's parts, each with priors of its own") {
  const std::string other =
      "[[world]]\nname = \"v\"\nsource = \"s\"\nset = [\"plant.model=lu2015\"]\n[world.tuning]\n"
      "\"plant.variation\" = [0.0, 0.1]\n[world.held_out]\n\"plant.variation\" = [0.2, 0.3]\n";
  const Study s = study_in(kHead + kWorld + other, "", "held_out");
  REQUIRE(s.parts.size() == 2);
  CHECK(s.seeds == std::vector<std::uint64_t>{11, 12, 13, 14});
  CHECK(s.metrics == std::vector<std::string>{"rms_um"});
  std::vector<Experiment> e = study_experiments(s, ".");
  for (std::size_t part = 0; part < 2; ++part) draw_lab(s, part, 12, e[part]);
  CHECK((e[0].plant.size_std >= 0.02 && e[0].plant.size_std <= 0.05));
  CHECK((e[1].plant.variation >= 0.2 && e[1].plant.variation <= 0.3));
  CHECK(e[0].plant.drift == e[1].plant.drift);  // of all worlds: one draw of a seed
}

TEST_CASE("A world's own range of a key replaces that of all worlds") {
  const std::string own =
      "[[world]]\nname = \"w\"\nsource = \"s\"\n[world.tuning]\n\"plant.drift\" = [0.0, 0.1]\n"
      "[world.held_out]\n\"plant.drift\" = [0.5, 0.6]\n";
  const Study s = study_in(kHead + own, "", "held_out");
  REQUIRE(s.parts[0].priors.size() == 1);
  CHECK(s.parts[0].priors[0].low == 0.5);
}

TEST_CASE("No scheme can be tuned in a world that is unseen") {
  const std::string unseen =
      "[[world]]\nname = \"u\"\nsource = \"s\"\nunseen = true\n[world.held_out]\n\"plant.flow\" = [0.9, "
      "1.1]\n";
  CHECK(study_in(kHead + kWorld + unseen, "", "tuning").parts.size() == 1);
  CHECK(study_in(kHead + kWorld + unseen, "", "held_out").parts.size() == 2);
}

TEST_CASE("A study takes the first of the declared labs, and no more than there are") {
  CHECK(study_in(kHead + kWorld, "seeds = 2\n", "held_out").seeds == std::vector<std::uint64_t>{11, 12});
  CHECK_THROWS_WITH(study_in(kHead + kWorld, "seeds = 5\n", "held_out"),
                    Catch::Contains("declares 4 labs of this kind"));
}

TEST_CASE("A declaration that cannot be kept is refused by file, key and limit") {
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {kHead, "declare at least one"},
           {kHead + kWorld + kWorld, "given twice"},
           {kHead + "[[world]]\nname = \"w\"\n", "source: is missing"},
           {kHead + "[[world]]\nname = \"w\"\nsource = \"s\"\nsources = 1\n", "nearest known one is source"},
           {kHead + "[[world]]\nname = \"w\"\nsource = \"s\"\n", "world.tuning: w has no such section"},
           {kHead + "[[world]]\nname = \"w\"\nsource = \"s\"\nunseen = 1\n", "true or false"},
           {kHead + "[[world]]\nname = \"w\"\nsource = \"s\"\nunseen = true\n[world.tuning]\n\"plant.drift\" "
                    "= [0, 1]\n",
            "nothing is tuned in it"},
           {kHead + "[[world]]\nname = \"w\"\nsource = \"s\"\n[world.tuning]\n\"plant.drift\" = [0.1, 0.2]\n"
                    "[world.held_out]\n\"plant.size_std\" = [0, 0.1]\n",
            "from the range that it has for tuning"},
           {"metrics = [\"rms_um\"]\n[seeds]\ntuning = [1, 3]\nheld_out = [3, 4]\n" + kWorld,
            "seed 3 is of tuning and of held_out"},
           {"metrics = [\"rms_um\"]\n[seeds]\nheld_out = [3, 1]\n" + kWorld, "[FIRST, LAST]"},
           {"metrics = [\"rms_um\"]\n[seeds]\ntuning = [3, 3]\n" + kWorld, "seeds.held_out: is missing"},
           {"metrics = [\"rms_um\"]\n[seeds]\nheld_out = [3, 3]\n" + kWorld, "seeds.tuning: is missing"},
           {"metrics = [\"rms_um\"]\nseeds = 3\n" + kWorld, "must be a section"},
           {"[seeds]\nheld_out = [3, 3]\ntuning = [1, 1]\n" + kWorld, "metrics: is missing"},
           {kHead + kWorld + "[[goal]]\nname = \"g\"\n", "says nothing"},
           {kHead + kWorld + "[[goal]]\nname = \"g\"\nsays = \"x\"\nmetric = \"layers\"\n",
            "not one of the metrics"},
           {"world = 1\n" + kHead, "must be written as [[world]]"},
           {"tuning = 1\n" + kHead + kWorld, "must be a section of keys of plant.*"},
           {"x", "w.toml:1"}}) {
    CAPTURE(text);
    CHECK_THAT(worlds_refusal(text), Catch::Contains(part));
  }
}

TEST_CASE("A study of worlds cannot change what is declared") {
  for (const auto& [rest, part] : std::vector<std::pair<std::string, std::string>>{
           {"experiment = \"x.toml\"\n", "declared by the file of worlds"},
           {"metrics = [\"rms_um\"]\n", "declared by the file of worlds"},
           {"seeds = [1, 2]\n", "count of the declared labs"}})
    CHECK_THROWS_WITH(study_in(kHead + kWorld, rest, "held_out"), Catch::Contains(part));
  CHECK_THROWS_WITH(study_in(kHead + kWorld, "", "mine"), Catch::Contains("one of tuning, held_out"));
  CHECK_THROWS_WITH(parse_study("worlds = \"w.toml\"\n[[scheme]]\nname = \"a\"\n", "s.toml"),
                    Catch::Contains("labs: is missing"));
  CHECK_THROWS_WITH(parse_study("labs = \"tuning\"\nseeds = 1\n[[scheme]]\nname = \"a\"\n", "s.toml"),
                    Catch::Contains("no meaning without worlds"));
}
