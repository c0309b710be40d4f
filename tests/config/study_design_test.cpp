// Sections of a study file that vary keys: zip, sample, prior; vary is in study_test.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "config/error.h"
#include "config/fields.h"
#include "config/study_labs.h"

using namespace firn;

namespace {

Study designed(const std::string& sections) {
  return parse_study("seeds = 8\nset = [\"control.scheme=smf\"]\n" + sections, "s.toml");
}

std::string refusal_of(const std::string& sections) {
  try {
    const Study s = designed(sections);
    for (const Experiment& e : study_experiments(s, "")) check_labs(s, 0, e);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("The n-th values of all keys of a zip belong together") {
  const Study s =
      designed("[zip]\n\"control.smf.kp\" = [0.5, 1, 1.5]\ncontrol.smf.ki_star = [0.1, 0.2, 0.3]\n");
  REQUIRE(s.arms.size() == 3);
  CHECK(s.arms[1].name == "ki_star=0.2 kp=1");
  const std::vector<Experiment> e = study_experiments(s, "");
  for (std::size_t n = 0; n < 3; ++n) {
    CHECK(e[n].control.smf.kp == 0.5 * double(n + 1));
    CHECK(e[n].control.smf.ki_star == Approx(0.1 * double(n + 1)));
  }
}

TEST_CASE("Every scheme meets every combination of varied, zipped and sampled settings") {
  const Study s = designed(
      "[[scheme]]\nname = \"a\"\n[[scheme]]\nname = \"b\"\n[vary]\n\"plant.drift\" = [0.0, 0.1]\n"
      "[zip]\n\"control.smf.kp\" = [1, 2, 3]\n[sample]\ndesign = \"sobol\"\npoints = 4\n"
      "\"control.smf.ki_star\" = [0.0, 1.0]\n");
  CHECK(s.arms.size() == 2 * 2 * 3 * 4);
  std::set<std::vector<std::string>> settings;
  for (const StudyEntry& arm : s.arms) settings.insert(arm.overrides);
  CHECK(settings.size() == 2 * 3 * 4);
}

TEST_CASE("Each interval of a range holds one setting of a Latin hypercube and of Sobol's points") {
  for (const std::string design : {"latin", "sobol"}) {
    const Study s = designed("[sample]\ndesign = \"" + design +
                             "\"\npoints = 16\nseed = 4\n\"control.smf.kp\" = [1.0, 3.0]\n"
                             "\"control.smf.ki_star\" = {from = 0.01, to = 1.0, scale = \"log\"}\n");
    std::set<int> of_kp, of_ki;
    for (const Experiment& e : study_experiments(s, "")) {
      of_kp.insert(int((e.control.smf.kp - 1.0) / 2.0 * 16));
      of_ki.insert(int(std::log10(e.control.smf.ki_star / 0.01) / 2.0 * 16));
    }
    INFO(design);
    CHECK(of_kp.size() == 16);
    CHECK(of_ki.size() == 16);
  }
}

TEST_CASE("A range with two integers as ends gives integers, each once and both ends among them") {
  const Study s = designed("[sample]\npoints = 64\n\"control.mpc.horizon\" = [1, 4]\n");
  std::set<int> horizons;
  for (const StudyEntry& arm : s.arms) horizons.insert(std::stoi(arm.overrides.front().substr(20)));
  CHECK(horizons == std::set<int>{1, 2, 3, 4});
  CHECK(s.arms.size() == 4);
}

TEST_CASE("A seed has one lab whatever the scheme, and other seeds have other labs") {
  const Study s = designed(
      "[[scheme]]\nname = \"a\"\n[[scheme]]\nname = \"b\"\nset = [\"control.smf.kp=2\"]\n"
      "[prior]\n\"plant.drift\" = [0.01, 0.2]\n\"plant.sensor_noise_mm\" = {mean = 0.002, std = 0.0005}\n");
  std::set<double> drifts;
  for (const std::uint64_t seed : s.seeds) {
    std::vector<Experiment> e = study_experiments(s, "");
    for (Experiment& one : e) draw_lab(s, 0, seed, one);
    CHECK(e[0].plant.drift == e[1].plant.drift);
    CHECK(e[0].plant.sensor_noise_mm == e[1].plant.sensor_noise_mm);
    CHECK((e[0].plant.drift >= 0.01 && e[0].plant.drift <= 0.2));
    drifts.insert(e[0].plant.drift);
  }
  CHECK(drifts.size() == s.seeds.size());
}

TEST_CASE("A key's labs do not change with the other keys that a study draws") {
  const std::string drift = "[prior]\n\"plant.drift\" = [0.01, 0.2]\n";
  CHECK(drawn_lab(designed(drift + "[vary]\n\"control.smf.kp\" = [1]\n"), 0, 3).front() ==
        drawn_lab(designed(drift +
                           "\"plant.sensor_noise_mm\" = [0.001, 0.002]\n[vary]\n\"control.smf.kp\" = [1]\n"),
                  0, 3)
            .front());
}

TEST_CASE("Labs drawn over a range have its mean, and normal ones their deviation") {
  const auto moments = [](const KeyRange& r) {
    double sum = 0.0, squares = 0.0;
    for (std::uint64_t seed = 1; seed <= 4000; ++seed) {
      const std::string text = r.drawn(seed);
      const double value = std::stod(text.substr(text.find('=') + 1));
      sum += value;
      squares += value * value;
    }
    const double mean = sum / 4000;
    return std::pair(mean, std::sqrt(squares / 4000 - mean * mean));
  };
  const auto [mean, std] = moments({"plant.a", 2.0, 6.0, KeyRange::Law::kUniform});
  CHECK(mean == Approx(4.0).margin(0.08));
  CHECK(std == Approx(4.0 / std::sqrt(12.0)).margin(0.05));
  const auto [log_mean, log_std] = moments({"plant.b", 1.0, 100.0, KeyRange::Law::kLogUniform});
  CHECK(log_mean == Approx(99.0 / std::log(100.0)).margin(1.5));
  const auto [normal_mean, normal_std] = moments({"plant.c", 5.0, 0.5, KeyRange::Law::kNormal});
  CHECK(normal_mean == Approx(5.0).margin(0.04));
  CHECK(normal_std == Approx(0.5).margin(0.03));
}

TEST_CASE("What no design can be is refused by file, line, key and limit") {
  const std::string one = "[[scheme]]\nname = \"a\"\n";
  for (const auto& [sections, part] : std::vector<std::pair<std::string, std::string>>{
           {"[zip]\n\"control.smf.kp\" = [1, 2]\n\"control.smf.ki_star\" = [1]\n", "belong together"},
           {"[zip]\n", "names no key"},
           {"[vary]\n\"control.smf.kp\" = [1]\n[zip]\n\"control.smf.kp\" = [2]\n", "varied twice"},
           {"[sample]\n\"control.smf.kp\" = [1, 2]\n", "points: is missing"},
           {"[sample]\npoints = 65\n\"control.smf.kp\" = [1, 2]\n", "[1, 64]"},
           {"[sample]\npoints = 3\n", "1 to 6 keys"},
           {"[sample]\npoints = 3\ndesign = \"halton\"\n\"control.smf.kp\" = [1, 2]\n", "\"sobol\""},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = [2, 1]\n", "ends below its beginning"},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = [1, 2, 3]\n", "must be a range"},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = {from = 0, to = 1, scale = \"log\"}\n", "above 0"},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = {mean = 0, std = 1}\n", "normal distribution"},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = {from = 0, until = 1}\n", "'until'"},
           {"[sample]\npoints = 3\n\"control.smf.kp\" = [1.0, nan]\n", "must be a range"},
           {one + "[prior]\n\"control.smf.kp\" = [1, 2]\n", "keys of plant.*"},
           {one + "[prior]\n\"plant.seed\" = [1, 2]\n", "keys of plant.*"},
           {one + "[prior]\n\"plant.drifts\" = [1.0, 2.0]\n", "plant.drift"},
           {one + "[prior]\n\"plant.ice.field_x0_mm\" = [1.0, 2.0]\n",
            "[prior], plant.ice.field_x0_mm: no key"},
           {one + "[prior]\n\"plant.drift\" = [5000.0, 6000.0]\n", "[prior], lowest values: plant.drift = "},
           {one + "[prior]\n\"plant.drift\" = {mean = 0.1, std = -1.0}\n", "negative"}}) {
    const std::string said = refusal_of(sections);
    INFO(sections << said);
    CHECK_THAT(said, Catch::Contains(part) && Catch::StartsWith("s.toml:"));
  }
}
