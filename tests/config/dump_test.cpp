#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "config/error.h"
#include "config/fields.h"
#include "config/include.h"
#include "config/markdown.h"
#include "core/grid/random.h"
#include "files/nearest.h"
#include "tests/config/texts.h"

using namespace firn;

namespace {

/// Sets every numeric field to a random value within its limits.
Experiment random_experiment(std::uint64_t seed) {
  Experiment e;
  RandomStream random(seed, Purpose::kTest);
  for (Field& f : fields(e)) {
    const double u = f.limits.min + (f.limits.max - f.limits.min) * random.uniform();
    if (auto* d = std::get_if<double*>(&f.value))
      **d = f.limits.min_excluded && u == f.limits.min ? f.limits.max : u;
    if (auto* i = std::get_if<std::int32_t*>(&f.value)) **i = std::int32_t(u);
    if (auto* i = std::get_if<std::int64_t*>(&f.value)) **i = std::int64_t(u);
    if (auto* i = std::get_if<std::uint64_t*>(&f.value)) **i = random.bits() >> 2;
  }
  for (int k = 0, layer = 1; k < int(random.below(4)); ++k, layer += 1 + int(random.below(9))) {
    if (k == 0) e.control.mpc.alpha.clear();
    e.control.mpc.alpha.push_back({layer, random.uniform()});
  }
  e.part.image = "a \"quoted\" \\ name.png";
  return e;
}

/// Values back from the dump without the checks across fields, which random values break.
std::string parsed_value(const std::string& key, const std::string& value) {
  try {
    parse_experiment(key + " = " + value, "x.toml");
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE(
    "A recorded experiment may have keys that only earlier versions had, a written one and --set may not") {
  const std::string text =
      "[laser_point]\npoll_s = 0.25\naveraging = 3\n[lab]\nkind = \"ice\"\n[control]\nscheme = \"smf\"\n"
      "[ice]\ncurves = \"ramped\"\nmesh = \"x.stl\"\nslice = \"x.toml\"\nmachine = \"x.toml\"\n";
  CHECK(parse_experiment(text, "recorded").laser_point.averaging == 3);
  CHECK(parse_recorded_experiment(text, "recorded").laser_point.averaging == 3);
  CHECK(parse_recorded_experiment(text, "recorded").ice.mesh == "x.stl");
  const std::string again = dump(parse_experiment(text, "recorded"));
  const std::size_t laser = again.find("[laser_point]\n");
  REQUIRE(laser != std::string::npos);
  const std::string section = again.substr(laser, again.find("\n[", laser + 1) - laser);
  CHECK(section.find("\npoll_s = ") == std::string::npos);
  CHECK(again.find("\ncurves = ") == std::string::npos);
  const std::vector<ConfigError> mistakes = mistakes_of({{"mine.toml", text}}, {});
  REQUIRE(mistakes.size() == 2);
  CHECK_THAT(mistakes[0].what(), Catch::Contains("mine.toml:2: laser_point.poll_s: unknown key") &&
                                     Catch::Contains("laser_point.poll_idle_s"));
  CHECK_THAT(mistakes[1].what(), Catch::Contains("mine.toml:9: ice.curves: unknown key"));
  CHECK_THROWS_WITH(parse_recorded_experiment(text, "recorded", {"laser_point.poll_s=1"}),
                    Catch::Contains("laser_point.poll_s"));
  CHECK_THROWS_WITH(parse_recorded_experiment(text, "recorded", {"ice.curves=ramped"}),
                    Catch::Contains("ice.curves"));
}

TEST_CASE(
    "Recorded experiments that are read in turn are each their own text's, also after one that is refused") {
  Experiment a, b;
  a.control.smf.kp = 0.25;
  b.control.smf.kp = 0.75;
  const std::string first = dump(a), second = dump(b);
  for (const int round : {1, 2}) {
    CAPTURE(round);
    CHECK(parse_recorded_experiment(first, "recorded").control.smf.kp == 0.25);
    CHECK(parse_recorded_experiment(first, "recorded", {"control.smf.kp=0.5"}).control.smf.kp == 0.5);
    CHECK(parse_recorded_experiment(first, "recorded").control.smf.kp == 0.25);
    CHECK(parse_recorded_experiment(second, "recorded").control.smf.kp == 0.75);
    CHECK_THROWS(parse_recorded_experiment(second + "nonsense", "recorded"));
  }
}

TEST_CASE("parse(dump(e)) is e, and its dump is the same bytes") {
  for (const std::string& text : {std::string(), std::string(test::kExperiment)}) {
    const Experiment e = parse_experiment(text, "x.toml");
    const std::string first = dump(e);
    const Experiment again = parse_experiment(first, "dump");
    CHECK(differences(e, again).empty());
    CHECK(dump(again) == first);
  }
}

TEST_CASE("Any double within its limits survives the dump bit for bit") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const double value = random_uniform({seed, Purpose::kTest});
    Experiment e;
    e.plant.sensor_noise_mm = value * (seed % 2 ? 1e-9 : 1.0);
    e.plant.placement_std_mm = 5e-324;  // the smallest one
    const Experiment again = parse_experiment(dump(e), "dump");
    CHECK(again.plant.sensor_noise_mm == e.plant.sensor_noise_mm);
    CHECK(again.plant.placement_std_mm == e.plant.placement_std_mm);
  }
}

TEST_CASE("No field's random value is refused for its type or limit when written as the dump writes it") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Experiment e = random_experiment(seed);
    for (const Field& f : fields(e)) {
      CHECK(broken_limit(f) == "");
      const std::string problem = parsed_value(std::string(f.key), value_text(f));
      INFO(problem);
      CHECK(problem.find(": must be a " + std::string(type_text(f))) == std::string::npos);
      CHECK(problem.find("must lie in") == std::string::npos);
      CHECK(problem.find("unknown key") == std::string::npos);
    }
  }
}

TEST_CASE("Both zeros dump as the same bytes") {
  const Experiment plus = parse_experiment("grid.origin_x_mm = 0.0", "x.toml");
  const Experiment minus = parse_experiment("grid.origin_x_mm = -0.0", "x.toml");
  CHECK(dump(plus) == dump(minus));
}

TEST_CASE("Differences name exactly the keys whose values differ") {
  Experiment b = parse_experiment("control.scheme = \"smf\"\ncontrol.smf.kp = 0.5", "x.toml");
  const auto d = differences(Experiment{}, b);
  REQUIRE(d.size() == 2);
  CHECK(d[0].key == "control.scheme");
  CHECK(d[0].a == "\"mpc\"");
  CHECK(d[0].b == "\"smf\"");
  CHECK(d[1].key == "control.smf.kp");
  CHECK(differences(b, b).empty());
}

TEST_CASE("Every key stands once, its section once, and every default keeps its limits") {
  Experiment e;
  std::set<std::string_view> keys, closed;
  std::string_view section;
  for (const Field& f : fields(e)) {
    CHECK(keys.insert(f.key).second);
    CHECK(f.key.find('.') != std::string_view::npos);
    CHECK_FALSE(f.meaning.empty());
    CHECK((f.key == "part.image" || broken_limit(f) == ""));
    if (f.section() != section) CHECK(closed.insert(section = f.section()).second);
    for (const char* unit : {"_mm", "_s", "_mm_s", "_mm_s2", "_hz", "_us", "_v"})
      if (f.key.ends_with(unit) && !f.key.ends_with("per_mm")) CHECK_FALSE(f.unit.empty());
  }
}

TEST_CASE("The nearest word is the one with the fewest edits, and none when nothing is near") {
  CHECK(nearest("mcp", {"open_loop", "smf", "mpc"}) == "mpc");
  CHECK(nearest("pipe", {"cylinder", "pipe"}) == "pipe");
  CHECK(nearest("zzzz", {"cylinder", "pipe"}) == "");
  CHECK(nearest("", {"a"}) == "");
}

TEST_CASE("docs/configuration.md is what the table of fields writes") {
  std::ifstream in(std::string(FIRN_SOURCE_DIR) + "/docs/configuration.md");
  std::stringstream committed;
  committed << in.rdbuf();
  const bool same = committed.str() == configuration_markdown();
  INFO("write it again with: ./firn config docs");
  CHECK(same);
}

TEST_CASE("Includes are read from base to leaf, relative to the file that names them") {
  namespace fs = std::filesystem;
  const fs::path root = fs::path(FIRN_BINARY_DIR) / "test-config-include";
  fs::remove_all(root);
  fs::create_directories(root / "labs");
  fs::create_directories(root / "experiments");
  const auto write = [&](const char* name, const char* text) { std::ofstream(root / name) << text; };
  write("labs/base.toml", "grid.nx = 50\ngrid.ny = 51");
  write("labs/lab.toml", "include = \"base.toml\"\ngrid.ny = 52\nmodel.h1_mm = 0.005");
  write("experiments/x.toml", "include = \"../labs/lab.toml\"\nmodel.h1_mm = 0.006");
  const Experiment e = load_experiment(root / "experiments/x.toml", {"model.h2_mm=0.001"});
  CHECK(e.grid.nx == 50);
  CHECK(e.grid.ny == 52);
  CHECK(e.model.h1_mm == 0.006);
  CHECK(e.model.h2_mm == 0.001);

  write("labs/loop.toml", "include = \"loop.toml\"");
  CHECK_THROWS_WITH(load_experiment(root / "labs/loop.toml"), Catch::Contains("comes back to itself"));
  write("labs/lost.toml", "include = \"nowhere.toml\"");
  CHECK_THROWS_WITH(load_experiment(root / "labs/lost.toml"),
                    Catch::Contains("nowhere.toml: no such file (included by"));
  CHECK_THROWS_AS(load_experiment(root / "labs"), ConfigError);
  fs::remove_all(root);
}
