// firn tune from the run folder of an ice print.
#include <catch2/catch.hpp>

#include "files/json.h"
#include "files/path/layer_file.h"
#include "tests/cli/run_firn.h"
#include "tests/support/ice_print.h"

namespace firn::test {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;

constexpr int kIntervals = 6;

fs::path printed_block() {
  const fs::path root = fresh_folder("tune-ice");
  const slice::PrintPaths paths = ice_block(kIntervals);
  LayerWriter file(root / "block.paths", paths.head);
  for (const slice::LayerPaths& l : paths.layers) file.add(slice::encode(l), l, slice::material_use(l));
  file.finish();
  const Said said = firn_says(
      {"print", std::string(FIRN_SOURCE_DIR) + "/labs/ice-cobra600.toml", "--bus", "in-process", "--runs",
       root.string(), "--set", "ice.paths=\"" + (root / "block.paths").string() + "\"", "--set",
       "ice.interval_layers=1", "--set", "control.scheme=smf", "--set", "control.smf.kp=0.1"});
  CAPTURE(said.out, said.err);
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.is_directory()) return entry.path();
  FAIL("no run");
  return {};
}

}  // namespace

TEST_CASE("firn tune answers from an ice print's log in its own words, and writes its page") {
  const fs::path run = printed_block();
  const fs::path page = run.parent_path() / "tuned.html";
  const Said said = firn_says({"tune", run.string(), "--keys", "control.smf.kp=0.05:1.4", "--budget", "300",
                               "--json", "-o", page.string()});
  CAPTURE(said.out, said.err);
  REQUIRE(said.code == 0);
  const auto j = nlohmann::json::parse(said.out);
  CHECK(j.at("laboratory").at("class") == "ice");
  CHECK(j.at("check").at("passed") == true);
  const auto& advice = j.at("advice");
  CHECK(advice.at("gain_interval").at(0) <= advice.at("gain"));
  CHECK(advice.at("keys").at(0).at("key") == "control.smf.kp");
  CHECK_THAT(file_text(page), Contains("</html>") && Contains("plant.ice.flow_water_mm3_s"));
  CHECK_THAT(file_text(page), !Contains("droplet"));
}

}  // namespace firn::test
