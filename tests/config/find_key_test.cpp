#include "config/find_key.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "config/error.h"

namespace firn {
namespace {

struct Table {
  Experiment defaults;
  std::vector<Field> fields = firn::fields(defaults);
  std::vector<std::string> find(const std::string& query) const {
    std::vector<std::string> keys;
    for (const Field* f : find_fields(fields, query)) keys.push_back(f->key);
    return keys;
  }
};

TEST_CASE("keys are found by words of their names and sentences, the likeliest first") {
  const Table t;
  CHECK(t.find("max layers").front() == "control.max_layers");
  CHECK(t.find("exposure").front() == "process.exposure_s");
  const auto integral = t.find("integral gain");
  CHECK(std::ranges::find(integral, "control.smf.ki_star") != integral.end());
  CHECK(t.find("gain Barnett").front() == "control.smf.kp");
  CHECK(t.find("qqqq").empty());
  CHECK(t.find("").empty());
}

TEST_CASE("the names that laboratories use lead to keys that exist, first of all that are found") {
  const Table t;
  for (const auto& [name, key] : names_of_the_field()) {
    CAPTURE(name, key);
    const auto found = t.find(std::string(name));
    const auto place = std::ranges::find(found, key);
    REQUIRE(place != found.end());
    const auto same = std::ranges::count(names_of_the_field(), name, &NameOfTheField::name);
    CHECK(place - found.begin() < same);
  }
}

TEST_CASE("an unknown key is likened by its words, not by the letters of the whole key") {
  const Table t;
  CHECK(likeliest_key(t.fields, "process.max_layers") == "control.max_layers");
  CHECK(likeliest_key(t.fields, "max_layers") == "control.max_layers");
  CHECK(likeliest_key(t.fields, "smf.kp") == "control.smf.kp");
  CHECK(likeliest_key(t.fields, "lamp.exposure_time_s") == "process.exposure_s");
  CHECK(likeliest_key(t.fields, "mpc.horizont") == "control.mpc.horizon");
  CHECK(likeliest_key(t.fields, "stage.speed_max_mm_s") == "stage.max_speed_mm_s");
  CHECK(likeliest_key(t.fields, "qqqq.zzzz").empty());
}

TEST_CASE(
    "every key is the likeliest one for itself, for itself without its section, and with a letter missing") {
  const Table t;
  for (const Field& f : t.fields) {
    CHECK(likeliest_key(t.fields, f.key) == f.key);
    if (f.name().size() < 6) continue;
    const std::string cut = f.key.substr(0, f.key.size() - 1);
    CHECK_FALSE((likeliest_key(t.fields, f.key + "x").empty() && likeliest_key(t.fields, cut).empty()));
  }
}

TEST_CASE("all mistakes of an experiment are reported, and the rules between keys once the keys are right") {
  const auto problems = [](const std::string& text, const std::vector<std::string>& overrides = {}) {
    std::vector<std::string> all;
    for (const ConfigError& e : mistakes_of({{"x.toml", text}}, overrides)) all.push_back(e.what());
    return all;
  };
  CHECK(problems("").empty());
  const auto three =
      problems("[grid]\nnx = -1\npich_x_mm = 1\n[control]\nscheme = \"best\"\n", {"lamp.max=3"});
  REQUIRE(three.size() == 4);
  CHECK_THAT(three[0] + three[1] + three[2] + three[3],
             Catch::Contains("x.toml:2: grid.nx = -1") && Catch::Contains("x.toml:3: grid.pich_x_mm") &&
                 Catch::Contains("x.toml:5: control.scheme") && Catch::Contains("--set: lamp.max"));
  CHECK(problems("[part]\nshape = \"cuboid\"\nwidth_mm = 900\ndepth_mm = 900\n").size() >= 2);
  CHECK(problems("[grid\n").size() == 1);
}

}  // namespace
}  // namespace firn
