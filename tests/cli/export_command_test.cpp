// firn import and firn export: refusals, and that nothing is left behind.
#include <catch2/catch.hpp>
#include <filesystem>

#include "files/exit_codes.h"
#include "files/json.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const char* const kRows =
    "layer,x_mm,y_mm,height_um,drops\n"
    "0,0,0,1,\n0,0.5,0,0,\n1,0,0,6,1\n1,0.5,0,,1\n2,0,0,11,2\n2,0.5,0,9,0\n";

struct Import {
  fs::path folder, record;
  Said said;
};

Import import_of(const std::string& name, const std::string& rows, std::vector<std::string> more = {}) {
  Import i{fresh_folder(name), {}, {}};
  i.record = i.folder / "record.csv";
  write_file_text(i.record, rows);
  std::vector<std::string> words{"import", i.record.string(), "--runs", (i.folder / "runs").string()};
  words.insert(words.end(), more.begin(), more.end());
  i.said = firn_says(words);
  return i;
}

}  // namespace

TEST_CASE("An imported table is a run of its layers, with every assumption said") {
  const Import i = import_of("import-whole", kRows, {"--json", "--input-per-drop", "1", "--name", "theirs"});
  INFO(i.said.err);
  REQUIRE(i.said.code == kOk);
  const auto said = nlohmann::json::parse(i.said.out);
  CHECK(said["layers"] == 2);
  CHECK(said["heights"] == 5);
  CHECK(said["missing"] == 1);
  CHECK(said["droplets"] == 4);
  CHECK(fs::exists(said["run"].get<std::string>()));
}

TEST_CASE("A record that cannot be read leaves no run") {
  for (const char* rows :
       {"", "layer\n1\n", "layer,x_mm,height_um\n1,0,a\n", "layer,x_mm,height_um\n1.5,0,1\n",
        "layer,x_parsec,height_um\n1,0,1\n", "layer,x_mm,y_mm,height_um\n1,0,1e99,1\n"}) {
    const Import i = import_of("import-refused", rows);
    INFO(rows << i.said.out);
    CHECK(i.said.code != kOk);
    CHECK_THAT(i.said.err, Contains("record.csv"));
    CHECK_FALSE(fs::exists(i.folder / "runs"));
  }
}

TEST_CASE("Options of a record that cannot be are refused by name") {
  CHECK_THAT(import_of("import-pitch", kRows, {"--pitch-mm", "-1"}).said.err, Contains("--pitch-mm"));
  CHECK_THAT(import_of("import-column", kRows, {"--column", "height=hight_um"}).said.err,
             Contains("no column 'hight_um'; the nearest is 'height_um'"));
  CHECK_THAT(import_of("import-input", kRows, {"--input", "/tmp"}).said.err,
             Contains("--input is of a record that is a folder"));
}

TEST_CASE("An export with an ending of no format, or of two runs with one name, writes nothing") {
  const fs::path folder = fresh_folder("export-refused");
  const std::string run = golden("v4-ice").string(), doc = (folder / "run.doc").string(),
                    npz = (folder / "run.npz").string();
  CHECK_THAT(firn_says({"export", run, "-o", doc}).err,
             Contains("run.doc: no format with this ending; there are .h5, .npz, .mcap and .csv"));
  CHECK_THAT(firn_says({"export", run, run, "-o", npz}).err, Contains("two runs have the name"));
  CHECK_THAT(firn_says({"export", (folder / "none").string(), "-o", npz}).err, Contains("none"));
  CHECK(fs::is_empty(folder));
}
