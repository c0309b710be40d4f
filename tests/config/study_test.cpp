#include "config/study.h"

#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/fields.h"
#include "core/grid/random.h"
#include "tests/config/texts.h"
#include "tests/support/temp_folder.h"

using namespace firn;

namespace {

const std::string kStudy = R"(name = "three"
seeds = 4
metrics = ["rms_um", "layers"]
baseline = "plain"
set = ["part.height_mm=0.05"]
[[scheme]]
name = "plain"
set = ["control.scheme=open_loop"]
[[scheme]]
name = "fed back"
set = ["control.scheme=smf", "control.smf.kp=0.8"]
[[part]]
name = "cuboid"
set = ["part.shape=cuboid", "part.width_mm=5", "part.depth_mm=5"]
[[part]]
name = "cylinder"
)";

std::string refusal(const std::string& text) {
  try {
    study_experiments(parse_study(text, "s.toml"), "");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE(
    "A study names schemes, parts, seeds and metrics, and resolves to an experiment for each scheme on each "
    "part") {
  const Study s = parse_study(kStudy, "s.toml");
  CHECK(s.name == "three");
  CHECK(s.seeds == std::vector<std::uint64_t>{1, 2, 3, 4});
  CHECK(s.metrics == std::vector<std::string>{"rms_um", "layers"});
  const std::vector<Experiment> e = study_experiments(s, "");
  REQUIRE(e.size() == 4);
  CHECK(e[0].control.scheme == "open_loop");
  CHECK(e[0].part.shape.kind == "cuboid");
  CHECK(e[1].part.shape.kind == "cylinder");
  CHECK(e[3].control.smf.kp == 0.8);
  for (const Experiment& one : e) CHECK(one.part.shape.height_mm == 0.05);
}

TEST_CASE("A lab of the study stands in the place of the one that its experiment includes") {
  const test::TempFolder folder;
  folder.file("lab.toml", "model.h1_mm = 0.004\nplant.drift = 0.2\n");
  folder.file("other.toml", "model.h1_mm = 0.005\n");
  folder.file("part.toml", "include = \"lab.toml\"\n[part]\nheight_mm = 0.07\n");
  Study s = parse_study("experiment = \"part.toml\"\n" + kStudy, "s.toml");
  CHECK(study_experiments(s, folder.path())[0].model.h1_mm == 0.004);
  s.lab = folder.path() / "other.toml";
  const Experiment e = study_experiments(s, folder.path())[0];
  CHECK(e.model.h1_mm == 0.005);
  CHECK(e.plant.drift == PlantConfig{}.drift);
  s.experiment = "other.toml";
  CHECK_THROWS_WITH(study_experiments(s, folder.path()), Catch::Contains("includes no lab"));
}

TEST_CASE("vary gives every scheme under every combination, or arms of its own without schemes") {
  const Study s = parse_study(
      "seeds = [7, 3]\n[[scheme]]\nname = \"mpc\"\n[vary]\n\"control.mpc.horizon\" = [1, 2]\n"
      "control.mpc.alpha = [1.0, 0.5, 0.25]\n",
      "s.toml");
  REQUIRE(s.arms.size() == 6);
  CHECK(s.seeds == std::vector<std::uint64_t>{7, 3});
  const auto e = study_experiments(s, "");
  int found = 0;
  for (std::size_t a = 0; a < 6; ++a)
    if (e[a].control.mpc.horizon == 2 && e[a].control.mpc.alpha[0].alpha == 0.25) {
      ++found;
      CHECK(s.arms[a].name.find("horizon=2") != std::string::npos);
      CHECK(s.arms[a].name.find("alpha=0.25") != std::string::npos);
    }
  CHECK(found == 1);
  const Study words = parse_study("seeds = 1\n[vary]\n\"control.scheme\" = [\"smf\", \"mpc\"]\n", "s.toml");
  REQUIRE(words.arms.size() == 2);
  CHECK(words.arms[0].name == "scheme=smf");
  CHECK(study_experiments(words, "")[1].control.scheme == "mpc");
}

TEST_CASE("A mistake in a study is told with file, line, key and limit") {
  const auto holds = [](const std::string& text, std::initializer_list<const char*> words) {
    const std::string what = refusal(text);
    CAPTURE(text, what);
    for (const char* w : words) CHECK(what.find(w) != std::string::npos);
  };
  holds("seeds = 3\n", {"s.toml", "scheme", "missing"});
  holds("[[scheme]]\nname = \"a\"\n", {"seeds", "missing"});
  holds("seeds = 0\n[[scheme]]\nname = \"a\"\n", {"s.toml:1", "seeds", "from 1"});
  holds("seeds = [1, 1]\n[[scheme]]\nname = \"a\"\n", {"different seeds"});
  holds("sedes = 3\n", {"s.toml:1", "sedes", "nearest known one is seeds"});
  holds("seeds = 3\n[[scheme]]\nname = \"a\"\nsets = []\n", {"s.toml:4", "scheme.sets", "set"});
  holds("seeds = 3\n[[scheme]]\nname = \"a\"\n[[scheme]]\nname = \"a\"\n", {"given twice"});
  holds("seeds = 3\n[[scheme]]\nset = []\n", {"s.toml:2", "no name"});
  holds("seeds = 3\n[[scheme]]\nname = \"../a\"\n", {"scheme.name", "letters"});
  holds("seeds = 3\nbaseline = \"b\"\n[[scheme]]\nname = \"a\"\n", {"s.toml:2", "baseline", "not one of a"});
  holds("seeds = 3\njudged = \"b\"\n[[scheme]]\nname = \"a\"\n", {"s.toml:2", "judged", "not one of a"});
  holds("seeds = 3\njudged = \"a\"\n[[scheme]]\nname = \"a\"\n", {"s.toml:2", "judged", "needs a baseline"});
  holds("seeds = 3\nmargin = 1.0\n[[scheme]]\nname = \"a\"\n", {"s.toml:2", "margin", "above 1"});
  holds("seeds = 3\n[[scheme]]\nname = \"a\"\nset = [\"control.scheme=mcp\"]\n",
        {"scheme 'a' on part 'part'", "control.scheme", "mpc"});
  holds("seeds = 3\n[[scheme]]\nname = \"a\"\nset = [\"control.kp=1\"]\n", {"scheme 'a'", "control.kp"});
  holds("seeds = 3\n[vary]\n\"control.mpc.horizon\" = [[1]]\n",
        {"vary", "control.mpc.horizon", "numbers and texts"});
  holds("seeds = 3\nmetrics = [\"a\", \"a\"]\n[[scheme]]\nname = \"a\"\n", {"s.toml:2", "metrics", "twice"});
  holds(
      "seeds = 100000\n[vary]\n\"plant.drift\" = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.91, 0.92]\n",
      {"1000000 prints"});
  holds("seeds = 3\n[[scheme]\n", {"s.toml:2", "column"});
}

TEST_CASE(
    "An experiment in the place of a study is told as one, and so is a study in the place of an experiment") {
  const auto of_experiment = Catch::Contains("is of an experiment, and this should be a study");
  CHECK_THAT(refusal("include = \"lab.toml\"\n[run]\nname = \"a\"\n"),
             Catch::StartsWith("s.toml:1: include") && of_experiment);
  CHECK_THAT(refusal("[part]\nheight_mm = 0.1\n"), Catch::StartsWith("s.toml:1: part") && of_experiment);
  CHECK_THAT(refusal("seeds = 3\n[part]\nname = \"a\"\n"), Catch::Contains("written as [[part]]"));
  CHECK_THROWS_WITH(parse_experiment(kStudy, "s.toml"),
                    Catch::Contains("s.toml:4: baseline: is of a study, and this should be an experiment"));
  CHECK_THROWS_WITH(parse_experiment("seeds = 2\n[[scheme]]\nname = \"a\"\n", "s.toml"),
                    Catch::Contains("is of a study, and this should be an experiment: firn compare"));
}

TEST_CASE("A study's name is its file's where it gives none") {
  const test::TempFolder folder;
  CHECK(load_study(folder.file("drift.toml", "seeds = 1\n[[scheme]]\nname = \"a\"\n")).name == "drift");
  CHECK(load_study(folder.file("named.toml", kStudy)).name == "three");
  CHECK_THROWS_WITH(load_study(folder.path() / "none.toml"), Catch::Contains("no such file"));
}

TEST_CASE("A study's experiment is found from the study's folder, and arms override parts, parts the study") {
  const test::TempFolder folder;
  folder.file("lab/base.toml", "[grid]\nnx = 30\nny = 30\n[part]\ndiameter_mm = 6\n");
  const Study s = parse_study(
      "experiment = \"../lab/base.toml\"\nseeds = 1\nset = [\"part.height_mm=0.1\", "
      "\"control.smf.kp=0.1\", \"control.smf.ki_star=0.1\"]\n"
      "[[scheme]]\nname = \"a\"\nset = [\"control.scheme=smf\", \"control.smf.kp=0.3\"]\n"
      "[[part]]\nname = \"p\"\nset = [\"control.smf.kp=0.2\", \"control.smf.ki_star=0.2\"]\n",
      "s.toml");
  const std::vector<Experiment> e = study_experiments(s, folder.path() / "studies");
  REQUIRE(e.size() == 1);
  CHECK(e[0].grid.nx == 30);
  CHECK(e[0].part.shape.height_mm == 0.1);
  CHECK(e[0].control.smf.kp == 0.3);
  CHECK(e[0].control.smf.ki_star == 0.2);
}

TEST_CASE("A study stays within its numbers of arms, parts, keys and metrics") {
  std::string values = "[0.001";
  for (int n = 2; n <= 65; ++n) values += ", 0." + std::to_string(1000 + n);
  CHECK_THAT(refusal("seeds = 1\n[vary]\n\"plant.drift\" = " + values + "]\n"),
             Catch::Contains("plant.drift must be a list of 1 to 64 numbers and texts"));
  CHECK_THAT(refusal("seeds = 1\n[vary]\n\"plant.drift\" = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]\n"
                     "\"plant.seed\" = [1, 2, 3, 4, 5, 6, 7, 8]\n"),
             Catch::Contains("more than 64 combinations"));
  CHECK_THAT(refusal("seeds = 1\n[vary]\na.a = [1]\na.b = [1]\na.c = [1]\na.d = [1]\na.e = [1]\na.f = [1]\n"
                     "a.g = [1]\n"),
             Catch::Contains("varies more than 6 keys"));
  std::string arms = "seeds = 1\n";
  for (int n = 0; n < 65; ++n) arms += "[[scheme]]\nname = \"a" + std::to_string(n) + "\"\n";
  CHECK_THAT(refusal(arms), Catch::Contains("more than 64 schemes"));
  std::string names = "seeds = 1\nmetrics = [\"m0\"";
  for (int n = 1; n <= 20; ++n) names += ", \"m" + std::to_string(n) + "\"";
  CHECK_THAT(refusal(names + "]\n[[scheme]]\nname = \"a\"\n"), Catch::Contains("1 to 20 names"));
}

TEST_CASE("A value of the wrong type in a study is named by its key") {
  const auto scheme = [](const std::string& line) {
    return refusal("seeds = 1\n" + line + "\n[[scheme]]\nname = \"a\"\n");
  };
  CHECK_THAT(scheme("name = 3"), Catch::Contains("name: must be text"));
  CHECK_THAT(scheme("name = \"\""), Catch::Contains("1 to 1000 bytes"));
  CHECK_THAT(scheme("experiment = [\"a\"]"), Catch::Contains("experiment: must be text"));
  CHECK_THAT(scheme("set = \"a=1\""), Catch::Contains("set: must be a list"));
  CHECK_THAT(scheme("metrics = []"), Catch::Contains("metrics: must be a list"));
  CHECK_THAT(scheme("part = 3"), Catch::Contains("written as [[part]]"));
  CHECK_THAT(scheme("vary = 3"), Catch::Contains("vary: must be a section"));
  CHECK_THAT(refusal("seeds = [-1]\n[[scheme]]\nname = \"a\"\n"), Catch::Contains("seeds of 0 or more"));
  CHECK_THAT(refusal("seeds = \"3\"\n[[scheme]]\nname = \"a\"\n"), Catch::Contains("must be a count"));
}

TEST_CASE("Random damage to a valid study gives a study within its limits or a ConfigError, nothing else") {
  static const std::string kAlphabet = "\"'[]{}=.,#\n\\-+0123456789eE_naif\0\xff\x80\xc3\r\t xu";
  RandomStream random(77, Purpose::kTest);
  const std::string varied =
      "seeds = [3, 4]\n[[scheme]]\nname = \"mpc\"\n[vary]\n\"control.mpc.horizon\" = [1, 2]\ncontrol.scheme "
      "= [\"mpc\", \"smf\"]\n";
  int accepted = 0, refused = 0;
  for (int n = 0; n < 4000; ++n) {
    std::string text = n % 2 ? kStudy : varied;
    for (std::uint32_t edits = 1 + random.below(2); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = random.below(std::uint32_t(text.size()));
      const char byte = random.below(4) ? kAlphabet[random.below(std::uint32_t(kAlphabet.size()))]
                                        : char(random.below(256));
      switch (random.below(5)) {
        case 0:
          text[at] = byte;
          break;
        case 1:
          text.insert(at, 1, byte);
          break;
        case 2:
          text.erase(at, 1 + random.below(8));
          break;
        case 3:
          text.insert(at, text.substr(random.below(std::uint32_t(text.size())), random.below(60)));
          break;
        default:
          text.resize(at + 1);
      }
    }
    try {
      const Study s = parse_study(text, "s.toml");
      REQUIRE(!s.seeds.empty());
      REQUIRE(s.seeds.size() <= kMaxSeeds);
      REQUIRE(!s.arms.empty());
      REQUIRE(s.arms.size() <= kMaxArms);
      REQUIRE(!s.parts.empty());
      for (const StudyEntry& a : s.arms) REQUIRE(!a.name.empty());
      for (Experiment& e : study_experiments(s, ""))
        for (const Field& f : fields(e)) REQUIRE(broken_limit(f) == "");
      ++accepted;
    } catch (const ConfigError&) {
      ++refused;
    }
  }
  CHECK(accepted > 60);
  CHECK(refused > 1000);
}
