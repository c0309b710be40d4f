#include <catch2/catch.hpp>

#include "config/error.h"
#include "config/experiment.h"
#include "config/fields.h"
#include "config/machine.h"
#include "tests/config/texts.h"

using namespace firn;

namespace {

struct Report {
  std::string what, key;
  int line = 0;
};

Report report_of(const std::string& toml) {
  try {
    parse_experiment(toml, "x.toml");
  } catch (const ConfigError& e) {
    return {e.what(), e.key, e.line};
  }
  return {"no error", "", -1};
}

std::string what_of(const std::string& toml) { return report_of(toml).what; }

}  // namespace

TEST_CASE("An experiment file sets the fields it names and leaves the others at Lu's lab") {
  const Experiment e = parse_experiment(test::kExperiment, "x.toml");
  CHECK(e.run.name == "cylinder-8");
  CHECK(e.grid.nx == 48);
  CHECK(e.grid.pitch_y_mm == 0.25);
  CHECK(e.grid.origin_x_mm == 1.5);
  CHECK(e.part.shape.kind == "pipe");
  CHECK(e.part.shape.diameter_mm == 9.0);  // an integer is a number
  CHECK(e.control.smf.kp == 0.9);
  CHECK(e.control.mpc.horizon == 2);
  REQUIRE(e.control.mpc.alpha.size() == 2);
  CHECK(e.control.mpc.alpha[1].from_layer == 20);
  CHECK(e.control.mpc.alpha[1].alpha == 1.0);
  CHECK(e.plant.seed == 9007199254740993u);  // beyond the exact integers of a double
  CHECK(e.stage.array_limit == StageConfig{}.array_limit);
}

TEST_CASE("A single alpha is a schedule of one step") {
  const Experiment e = parse_experiment("control.mpc.alpha = 0.5", "x.toml");
  REQUIRE(e.control.mpc.alpha.size() == 1);
  CHECK(e.control.mpc.alpha[0].from_layer == 1);
  CHECK(e.control.mpc.alpha[0].alpha == 0.5);
}

TEST_CASE("A value beyond its limit is reported with file, line, key, value, limit and unit") {
  const Report r = report_of("[grid]\nnx = 40\npitch_x_mm = -0.25\n");
  CHECK(r.what == "x.toml:3: grid.pitch_x_mm = -0.25: must lie in (0, 100] mm");
  CHECK(r.key == "grid.pitch_x_mm");
  CHECK(r.line == 3);
  CHECK(what_of("stage.x_min_mm = 1e300") ==
        "x.toml:1: stage.x_min_mm = 1e+300: must lie in [-10000, 10000] mm");
  CHECK(what_of("grid.nx = 0") == "x.toml:1: grid.nx = 0: must lie in [1, 4096]");
  CHECK(
      what_of("grid.nx = 9223372036854775807").find("grid.nx = 9223372036854775807: must lie in [1, 4096]") !=
      std::string::npos);
  CHECK(what_of("plant.seed = -1").find("plant.seed = -1: must lie in [0, 9e+18]") != std::string::npos);
}

TEST_CASE("Neither NaN nor infinity enters an experiment") {
  Experiment probe;
  for (const Field& f : fields(probe)) {
    if (!std::holds_alternative<double*>(f.value)) continue;
    for (const char* bad : {"nan", "inf", "-inf", "+nan", "1e999"}) {
      INFO(f.key << " = " << bad);
      CHECK(what_of(std::string(f.key) + " = " + bad) != "no error");
    }
  }
  CHECK(what_of("control.mpc.alpha = nan") != "no error");
  CHECK(what_of("control.mpc.alpha = [{from_layer = 1, alpha = inf}]") != "no error");
}

TEST_CASE("Every field refuses a value of the wrong type and says which it wants") {
  Experiment probe;
  for (const Field& f : fields(probe)) {
    for (const char* wrong : {"true", "1979-05-27", "{}", "[1, 2]"}) {
      if (std::string_view(wrong) == "[1, 2]" && type_text(f) == "list of numbers") continue;
      INFO(f.key << " = " << wrong);
      const std::string what = what_of(std::string(f.key) + " = " + wrong);
      CHECK(what.find(std::string(f.key)) != std::string::npos);
      CHECK(what.find(std::string(type_text(f))) != std::string::npos);
    }
  }
  CHECK(what_of("[grid]\nnx = 4.0") == "x.toml:2: grid.nx = 4.0: must be an integer in [1, 4096]");
  CHECK(what_of("grid.pitch_x_mm = \"0.2\"").find("must be a number [mm] in (0, 100]") != std::string::npos);
}

TEST_CASE("An integer that no double holds is judged by its key's limits like any other number") {
  for (const char* huge :
       {"-9223372036854775808", "9223372036854775807", "9007199254740993", "-9007199254740993"})
    for (const char* key : {"jet.dwell_v", "plant.drift", "grid.pitch_x_mm"}) {
      const std::string line = std::string(key) + " = " + huge;
      CHECK_THROWS_WITH(parse_experiment(line, "x.toml"),
                        Catch::Contains("x.toml:1: " + line) && Catch::Contains("must lie in"));
      CHECK_THROWS_WITH(parse_experiment(std::vector<std::pair<std::string, std::string>>{},
                                         {std::string(key) + "=" + huge}),
                        Catch::Contains("must lie in"));
    }
}

TEST_CASE("An unknown key is reported with the nearest known one") {
  CHECK(what_of("[grid]\n\npich_x_mm = 1.0") ==
        "x.toml:3: grid.pich_x_mm: unknown key; the nearest known one is grid.pitch_x_mm");
  CHECK(what_of("[controll]\nscheme = \"mpc\"").find("nearest known one is control") != std::string::npos);
  CHECK(what_of("horizon = 2").find("nearest known one is control.mpc.horizon") != std::string::npos);
  CHECK(what_of("xyzzy_plugh_quux = 1").find("unknown key") != std::string::npos);
}

TEST_CASE(
    "A machine's file where a lab's is wanted is refused as a whole, and a lab's where a machine's is") {
  CHECK(what_of("[aerosol]\nv_max_mm_s = 4.0\n[machine]\nkind = \"aerosol\"") ==
        "x.toml:3: [machine]: this is the file of a machine, and a lab's or an experiment's is wanted");
  CHECK_THROWS_WITH(
      parse_machine(
          "[calibration]\ntable_x_mm = 1.0\n[ice]\nmachine = \"../arm.toml\"\n[lab]\nkind = \"ice\"",
          "labs/ice/mine.toml"),
      Catch::Equals("labs/ice/mine.toml:5: [lab]: this is the file of a lab, and a machine's is wanted; its "
                    "machine is labs/arm.toml"));
}

TEST_CASE("An unknown word is reported with the allowed ones and the nearest") {
  const std::string what = what_of("[control]\nscheme = \"mcp\"");
  CHECK(what.find("x.toml:2: control.scheme = ") == 0);
  CHECK(what.find("did you mean \"mpc\"?") != std::string::npos);
  CHECK(what.find("one of open_loop, smf, threshold, mpc") != std::string::npos);
}

TEST_CASE("A section given as a value, and a broken file, are reported with their line") {
  CHECK(what_of("grid = 3").find("x.toml:1: grid = 3: is a section") == 0);
  CHECK(what_of("[[grid]]\nnx = 3").find("grid = [...]: is a section") != std::string::npos);
  CHECK(what_of("a = 1\nb = = 2").find("x.toml:2: column") == 0);
  CHECK(what_of(std::string(70000, '#')).find("70000 bytes") != std::string::npos);
  CHECK(what_of("x = \"" + std::string(3000, 'a') + "\"").find("line longer than") != std::string::npos);
}

TEST_CASE("An alpha schedule begins at layer 1 and ascends") {
  CHECK(what_of("control.mpc.alpha = [{from_layer = 2, alpha = 1.0}]").find("from_layer = 1") !=
        std::string::npos);
  CHECK(what_of("control.mpc.alpha = []").find("from_layer = 1") != std::string::npos);
  CHECK(what_of("control.mpc.alpha = [{from_layer = 1, alpha = 1.0}, {from_layer = 1, alpha = 0.5}]")
            .find("ascending") != std::string::npos);
  CHECK(what_of("control.mpc.alpha = [{from_layer = 1, alpha = 1.5}]").find("(0, 1]") != std::string::npos);
  CHECK(what_of("control.mpc.alpha = [{from_layer = 1, alhpa = 1.0}]") != "no error");
}

TEST_CASE("Overrides come last, in order, and need no quotes round words") {
  const Experiment e = parse_experiment(
      {{"x.toml", test::kExperiment}},
      {"control.scheme=smf", "control.mpc.horizon=3", "control.mpc.horizon=4", "control.mpc.alpha=0.25"});
  CHECK(e.control.scheme == "smf");
  CHECK(e.control.mpc.horizon == 4);
  CHECK(e.control.mpc.alpha.size() == 1);
  for (const char* bad : {"control.mpc.horizon", "=3", "control.mpc.horizn=3", "control.mpc.horizon=three",
                          "a b=1", "run.name=x\ngrid.nx=3", "include=lab.toml"}) {
    INFO(bad);
    CHECK_THROWS_AS(parse_experiment({{"x.toml", ""}}, {bad}), ConfigError);
    CHECK_THROWS_WITH(parse_experiment({{"x.toml", ""}}, {bad}), Catch::StartsWith("--set: "));
  }
  for (const char* assignment : {"control.shceme=mpc", "control.shceme=1", "control.shceme=[1"})
    CHECK_THROWS_WITH(
        parse_experiment({{"x.toml", ""}}, {assignment}),
        Catch::Equals("--set: control.shceme: unknown key; the nearest known one is control.scheme"));
  for (const char* assignment : {"run.name=007", "run.name=\"007\"", "run.name='007'"})
    CHECK(parse_experiment({{"x.toml", ""}}, {assignment}).run.name == "007");
}

TEST_CASE("Later texts override earlier ones, and an include without its text is an error") {
  const Experiment e = parse_experiment(
      {{"lab.toml", "[grid]\nnx = 50\nny = 45"}, {"x.toml", "include = \"lab.toml\"\ngrid.nx = 60"}}, {});
  CHECK(e.grid.nx == 60);
  CHECK(e.grid.ny == 45);
  CHECK(what_of("\ninclude = \"lab.toml\"").find("x.toml:2: include = ") == 0);
}
