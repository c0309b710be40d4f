// A whole print whose profiler is a point laser that the stage moves: preview, record, replay, audit.
#include <catch2/catch.hpp>

#include "config/include.h"
#include "print/labs/full_product.h"
#include "print/preview/print_preview.h"
#include "tests/cli/run_firn.h"

using namespace firn;
using namespace firn::test;

namespace {

std::vector<std::string> of_kind(const std::vector<std::string>& words, const std::string& kind) {
  std::vector<std::string> all = words;
  for (const std::string& set :
       {std::string("grid.nx=14"), std::string("grid.ny=12"), std::string("part.width_mm=2.6"),
        std::string("part.depth_mm=2.1"), std::string("part.height_mm=0.02"),
        "devices.laser_profiler.kind=\"" + kind + "\""})
    all.insert(all.end(), {"--set", set});
  return all;
}
const std::string kCuboid = FIRN_SOURCE_DIR "/experiments/cuboid.toml";

}  // namespace

TEST_CASE("a print measured by a point laser replays to the same bytes, and its audit is clean",
          "[point_scan]") {
  const auto folder = fresh_folder("point-scan");
  const Said printed = firn_says(
      of_kind({"print", kCuboid, "--bus", "in-process", "--runs", folder.string(), "--json"}, "lkg"));
  INFO(printed.out << printed.err);
  REQUIRE(printed.code == 0);
  const std::string run = std::filesystem::directory_iterator(folder)->path().string();
  CHECK(firn_says({"replay", run}).code == 0);
  CHECK(firn_says({"audit", run}).code == 0);
}

TEST_CASE("the preview tells how much longer a point laser scans", "[point_scan]") {
  const auto time_s = [](const char* kind) {
    const Experiment e =
        load_experiment(kCuboid, {std::string("devices.laser_profiler.kind=\"") + kind + "\""});
    return preview_print(e, make_inputs(full_product(), e, ""), "").time_s;
  };
  const Experiment e = load_experiment(kCuboid, {});
  const double scan_s = (e.grid.ny + 1) * e.grid.pitch_y_mm / e.process.scan_speed_mm_s;
  const int layers = preview_print(e, make_inputs(full_product(), e, ""), "").layers;
  CHECK(time_s("lkg") - time_s("ljv") > layers * (e.grid.nx - 1) * scan_s);
}
