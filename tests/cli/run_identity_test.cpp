// Which run a folder is: its number, its place, and documents of another run beside its records.
#include <algorithm>
#include <catch2/catch.hpp>

#include "files/json.h"
#include "files/usage_error.h"
#include "runs/folder/address.h"
#include "tests/cli/run_firn.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

/// Without seals, which would name any change.
fs::path unsealed(const std::string& name, std::int64_t run_id = 0) {
  const fs::path run = golden_copy("v1.0-mpc", name);
  fs::remove_all(run / "seals");
  auto provenance = nlohmann::json::parse(file_text(run / "provenance.json"));
  provenance.erase("sealed");
  if (run_id != 0) provenance["run_id"] = run_id;
  write_file_text(run / "provenance.json", provenance.dump(2));
  return run;
}

TEST_CASE(
    "provenance.json of another run beside write-ahead files is refused by every command that reads the "
    "run") {
  const fs::path run = unsealed("other-provenance", 5);
  const std::string folder = run.string();
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"audit", folder},
           {"replay", folder},
           {"report", folder, "--no-replay", "-o", (run / "r.html").string()},
           {"export", folder, "-o", (run / "x.npz").string()},
           {"identify", folder},
           {"print", "--resume", folder}}) {
    const Said said = firn_says(words);
    CAPTURE(words[0], said.out, said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Contains("provenance.json: is of run 5, and ") && Contains("put back the document"));
  }
}

TEST_CASE("audit names an experiment.toml that is not what the nodes recorded") {
  const fs::path run = unsealed("other-experiment");
  std::string text = file_text(run / "experiment.toml");
  const std::size_t at = text.find("nozzle_gap_mm = ");
  REQUIRE(at != std::string::npos);
  text.replace(at, text.find('\n', at) - at, "nozzle_gap_mm = 1.5");
  write_file_text(run / "experiment.toml", text);
  const Said said = firn_says({"audit", run.string()});
  CAPTURE(said.out, said.err);
  CHECK(said.code != 0);
  CHECK_THAT(said.out + said.err,
             Contains("experiment.toml is not what the nodes recorded: process.nozzle_gap_mm"));
}

TEST_CASE("a run is found by its number and by its address, and a copy makes the number two runs") {
  const fs::path root = fresh_folder("addresses");
  fs::copy(golden("v1.0-mpc"), root / "a", fs::copy_options::recursive);
  const runs::RunAddress a = runs::address_of(root / "a");
  CHECK(runs::parse_address(a.text()) == a);
  CHECK(runs::folder_of(std::to_string(a.run_id), root) == root / "a");
  fs::copy(root / "a", root / "b", fs::copy_options::recursive);
  CHECK(runs::address_of(root / "b").run_id == a.run_id);
  CHECK(runs::address_of(root / "b").place != a.place);
  CHECK(runs::folder_of(a.text(), root) == root / "a");
  CHECK(runs::folder_of((root / "b").string(), root) == root / "b");
  CHECK_THROWS_WITH(runs::folder_of(std::to_string(a.run_id), root),
                    Contains("several folders hold this run") && Contains("/a") && Contains("/b"));
  CHECK_THROWS_WITH(runs::folder_of("17", root), Contains("no run of this number"));
}

TEST_CASE("a text that is no address is none") {
  for (const char* text : {"", "@", "5@", "@0123456789ab", "5@0123456789a", "5@0123456789abc",
                           "5@0123456789aB", "-5@0123456789ab", "5 @0123456789ab",
                           "99999999999999999999@0123456789ab", "live", "20261128T120000Z-part"})
    CHECK_FALSE(runs::parse_address(text));
}

}  // namespace
}  // namespace firn::test
