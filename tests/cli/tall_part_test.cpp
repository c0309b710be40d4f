// A part that the nozzle would touch is refused by every command that knows it, before anything is printed.
#include <catch2/catch.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using Words = std::vector<std::string>;

constexpr const char* kPart =
    "[grid]\nnx = 9\nny = 8\n[part]\nshape = \"cuboid\"\nwidth_mm = 1.9\ndepth_mm = 1.6\n";

/// Experiments of one tall part beside a study of each.
struct TallParts {
  explicit TallParts(const std::string& name) : folder(fresh_folder("tall-" + name)) {}

  fs::path experiment(const std::string& name, const std::string& text) const {
    const fs::path file = folder / (name + ".toml");
    write_file_text(file, text);
    return file;
  }
  /// A study in which one scheme alone is changed.
  Words compared(const fs::path& experiment, const std::string& changed) const {
    const fs::path file = folder / ("study-" + experiment.filename().string());
    write_file_text(file, "name = \"tall\"\nexperiment = \"" + experiment.filename().string() +
                              "\"\nseeds = [1, 2]\n[[scheme]]\nname = \"as it is\"\nset = []\n"
                              "[[scheme]]\nname = \"changed\"\nset = [\"" +
                              changed + "\"]\n");
    return {"compare", file.string(), "-o", (folder / "runs" / "compared").string()};
  }
  /// Returns the commands that know the part of an experiment.
  std::vector<Words> commands(const fs::path& file, const Words& changed = {}) const {
    const std::string runs = (folder / "runs").string();
    std::vector<Words> all{{"print", file.string(), "--runs", runs},
                           {"print", file.string(), "--runs", runs, "--bus", "in-process"},
                           {"print", file.string(), "--runs", runs, "--detach"},
                           {"preview", file.string()},
                           {"config", "check", file.string()}};
    for (Words& words : all)
      for (const std::string& set : changed) words.insert(words.end(), {"--set", set});
    return all;
  }
  void check_refused(const Words& words, const std::string& why) const {
    const Said said = firn_says(words);
    INFO(Catch::StringMaker<Words>::convert(words) << said.out << said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains(why));
    CHECK((!fs::exists(folder / "runs") || fs::is_empty(folder / "runs")));
  }

  fs::path folder;
};

TEST_CASE("a part higher than the nozzle's gap is refused by print, preview, config check and compare") {
  const TallParts parts("droplets");
  const std::string why = "process.nozzle_gap_mm = 1: the part is 0.9 mm high";
  const fs::path high = parts.experiment("high", kPart + std::string("height_mm = 0.9\n"));
  for (const Words& words : parts.commands(high)) parts.check_refused(words, why);
  const fs::path low = parts.experiment("low", kPart + std::string("height_mm = 0.05\n"));
  for (const Words& words : parts.commands(low, {"part.height_mm=0.9"})) parts.check_refused(words, why);
  parts.check_refused(parts.compared(low, "process.nozzle_gap_mm=0.2"),
                      "process.nozzle_gap_mm = 0.2: the part is 0.05 mm high");
  CHECK(firn_says({"config", "check", low.string()}).code == 0);
}

TEST_CASE("with two nozzles the lower one must pass over the part") {
  const TallParts parts("two");
  const fs::path file = parts.experiment("two", kPart + std::string("height_mm = 0.5\n") +
                                                    "[geometry]\nshape = \"pipe\"\nouter_diameter_mm = 1.2\n"
                                                    "inner_diameter_mm = 0.5\n");
  CHECK(firn_says({"config", "check", file.string()}).code == 0);
  for (const char* offset : {"0.4", "-0.4"})
    for (const Words& words : parts.commands(file, {std::string("jet_b.offset_z_mm=") + offset}))
      parts.check_refused(words, "the lower nozzle is at 0.6 mm, the part is 0.5 mm high");
}

TEST_CASE("lines that would reach the nozzle are refused by print, preview, config check and compare") {
  const TallParts parts("lines");
  const fs::path folder = FIRN_SOURCE_DIR "/experiments";
  const fs::path file =
      parts.experiment("meander", "include = \"" + (folder / "aerosol-meander.toml").string() + "\"\n");
  fs::copy_file(folder / "aerosol-meander.json", parts.folder / "aerosol-meander.json");
  const std::string gap = "process.nozzle_gap_mm=0.001", why = "mm high, and process.nozzle_gap_mm = 0.001";
  for (const Words& words : parts.commands(file, {gap})) parts.check_refused(words, why);
  parts.check_refused(parts.compared(file, gap), why);
}

}  // namespace
}  // namespace firn::test
