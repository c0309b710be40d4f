// What is shown of a print before its first droplet, and parts that are refused before they are sliced.
#include <catch2/catch.hpp>
#include <cmath>

#include "config/error.h"
#include "config/include.h"
#include "core/grid/npy.h"
#include "files/json.h"
#include "files/usage_error.h"
#include "print/inputs/mesh_part.h"
#include "print/labs/full_product.h"
#include "print/preview/print_preview.h"
#include "print/simulated/lab_run.h"
#include "print/simulated/memory_print.h"
#include "tests/support/temp_folder.h"

using namespace firn;
using Catch::Matchers::Contains;

namespace {

const std::filesystem::path kPreviewed = std::filesystem::path(FIRN_SOURCE_DIR) / "experiments";

// An ASCII STL of a box, without one of its sides if `open`.
std::string box(double x, double y, double z, bool open = false, double z0 = 0.0) {
  const double p[8][3] = {{0, 0, z0}, {x, 0, z0}, {x, y, z0}, {0, y, z0},
                          {0, 0, z},  {x, 0, z},  {x, y, z},  {0, y, z}};
  const int t[12][3] = {{0, 2, 1}, {0, 3, 2}, {0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5},
                        {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}, {4, 5, 6}, {4, 6, 7}};
  std::string s = "solid\n";
  for (int f = 0; f < 12; ++f) {
    if (open && (f == 6 || f == 7)) continue;
    s += "facet normal 0 0 0\nouter loop\n";
    for (const int v : t[f])
      s += "vertex " + std::to_string(p[v][0]) + " " + std::to_string(p[v][1]) + " " +
           std::to_string(p[v][2]) + "\n";
    s += "endloop\nendfacet\n";
  }
  return s + "endsolid\n";
}

PrintPreview shown(const std::filesystem::path& file, std::vector<std::string> overrides = {}) {
  Experiment e = load_experiment(file, overrides);
  const Blobs inputs = make_inputs(full_product(), e, file.parent_path());
  complete_experiment(full_product(), e, inputs);
  return preview_print(e, inputs, file.parent_path());
}

}  // namespace

TEST_CASE(
    "A preview names size, cells, layers, droplets and volume of a cylinder, near what its print takes") {
  const std::vector<std::string> small{"part.height_mm=0.08", "grid.nx=24", "grid.ny=24",
                                       "part.diameter_mm=5"};
  const PrintPreview p = shown(kPreviewed / "cylinder.toml", small);
  CHECK(p.size_mm[0] == Approx(5.0).margin(0.3));
  CHECK(p.size_mm[1] == Approx(5.0).margin(0.3));
  CHECK(p.size_mm[2] == Approx(0.08));
  CHECK(double(p.cells) * 0.263256 * 0.263256 == Approx(M_PI * 6.25).epsilon(0.05));
  CHECK(p.volume_mm3 == Approx(M_PI * 6.25 * 0.08).epsilon(0.05));
  CHECK(p.layers == 11);  // 80 um of 7.6 um
  CHECK(p.outside.empty());
  CHECK(p.remarks.empty());
  const Experiment e = load_experiment(kPreviewed / "cylinder.toml", small);
  const MemoryPrintReport r = print_in_memory(full_product(), e, make_inputs(full_product(), e, kPreviewed));
  REQUIRE(r.result.status == 0);
  CHECK(double(p.amount) == Approx(double(r.droplets)).epsilon(0.25));
  CHECK(p.time_s == Approx(r.node_s).epsilon(0.5));
  const auto j = nlohmann::json::parse(preview_json(p));
  CHECK(j["droplets"] == p.amount);
  CHECK(j["layers"] == p.layers);
  CHECK_THAT(preview_svg(p), Contains("<svg") && Contains("</svg>"));
  CHECK_THAT(preview_text(p), Contains("cylinder, 4.74 x 4.74 x 0.08 mm") && Contains("about 11 layers") &&
                                  Contains("droplets"));
  CHECK_THAT(preview_text(shown(kPreviewed / "cylinder.toml", {"control.max_layers=3"})),
             Contains("remark: control.max_layers = 3: the print waits for you there") &&
                 Contains("--set control.max_layers="));
}

TEST_CASE(
    "A preview says what places inside the cells may cost: nearer droplets and more runs of the stage") {
  CHECK_THAT(
      preview_text(shown(kPreviewed / "cylinder.toml", {"actuation.offsets=x"})),
      Contains("remark: actuation.offsets: 5 places in a cell; droplets may be 66 um apart, which the jet "
               "follows at 125 of 150 mm/s"));
  CHECK_THAT(
      preview_text(shown(kPreviewed / "cylinder.toml",
                         {"actuation.offsets=grid", "actuation.positions_x=1", "actuation.positions_y=2"})),
      Contains("3 places in a cell; a row of cells is up to 3 runs of the stage") &&
          Contains("the jet follows the nearest droplets at full speed"));
}

TEST_CASE("A simulation of the scheme foretells layers, amount and time of twelve prints, within 15 %") {
  const std::vector<std::string> small{"part.height_mm=0.04", "grid.nx=20", "grid.ny=20",
                                       "part.diameter_mm=4"};
  for (const char* scheme : {"smf", "mpc", "threshold", "open_loop"})
    for (const char* seed : {"3", "4", "5"}) {
      std::vector<std::string> settings = small;
      settings.push_back(std::string("control.scheme=") + scheme);
      settings.push_back(std::string("plant.seed=") + seed);
      CAPTURE(scheme, seed);
      const Experiment e = load_experiment(kPreviewed / "cylinder.toml", settings);
      const Blobs inputs = make_inputs(full_product(), e, kPreviewed);
      const auto foretold = foretell(full_product(), e, inputs, 60.0);
      REQUIRE(foretold);
      PrintPreview p = preview_print(e, inputs, kPreviewed);
      take_foretold(*foretold, e, p);
      const test::TempFolder scratch;
      const runs::RunFolder run = runs::RunFolder::create(scratch.path() / "runs", e, inputs, {});
      const LabRunReport printed = run_in_lab(full_product(), run, {});
      REQUIRE(printed.result.outcome == "finished");
      CHECK(p.layers == Approx(printed.result.layers).epsilon(0.15));
      CHECK(p.time_s == Approx(printed.node_seconds).epsilon(0.15));
      CHECK_THAT(preview_text(p), Contains("(" + std::string(scheme) + ", simulated)"));
    }
}

TEST_CASE("Nothing is foretold where the simulation takes too long") {
  const Experiment e = load_experiment(kPreviewed / "cylinder.toml", {});
  CHECK_FALSE(foretell(full_product(), e, make_inputs(full_product(), e, kPreviewed), 0.001));
}

TEST_CASE(
    "A mesh is a part of one ink: its column heights, in the middle of the grid, scaled and in its unit") {
  const test::TempFolder f;
  f.file("box.stl", box(4.0, 3.0, 0.2));
  const auto experiment = [&](const std::string& more) {
    return f.file("x.toml", "part = {shape = \"mesh\", mesh = \"box.stl\"" + more + "}\n");
  };
  const std::filesystem::path plain = experiment("");
  const Experiment e = load_experiment(plain);
  const Blobs inputs = make_inputs(full_product(), e, f.path());
  const HeightMap target = height_map_from_npy(blob(inputs, "target").bytes, e.grid, "target");
  double volume = 0.0;
  for (const double h : target.cells) {
    CHECK((h == 0.0 || h == Approx(0.2)));
    volume += h * e.grid.pitch_x_mm * e.grid.pitch_y_mm;
  }
  CHECK(volume == Approx(4.0 * 3.0 * 0.2).epsilon(0.12));
  CHECK(target.at(20, 20) == Approx(0.2));
  PrintPreview p = shown(plain);
  CHECK(p.size_mm[0] == Approx(4.0).margin(0.27));
  CHECK(p.remarks.empty());
  p = shown(experiment(", mesh_scale_xy = 2.0, mesh_scale_z = 0.5"));
  CHECK(p.size_mm[0] == Approx(8.0).margin(0.27));
  CHECK(p.size_mm[2] == Approx(0.1));
}

TEST_CASE("Air below a part of one ink, a part beyond the grid and one of a few cells are named") {
  const test::TempFolder f;
  const std::filesystem::path x = f.file("x.toml", "part = {shape = \"mesh\", mesh = \"box.stl\"}\n");
  f.file("box.stl", box(4.0, 3.0, 0.2) + box(2.0, 2.0, 0.6, false, 0.4));
  CHECK_THROWS_WITH(shown(x), Contains("part.mesh") && Contains("air below") && Contains("geometry.mesh"));
  f.file("box.stl", box(4000.0, 3000.0, 200.0));  // micrometres
  CHECK_THROWS_WITH(shown(x), Contains("4000 x 3000 x 200 mm") && Contains("the grid") &&
                                  Contains("taken as micrometres it would be 4 x 3 x 0.2 mm"));
  CHECK_THROWS_AS(shown(x), ConfigError);
  f.file("box.stl", box(0.4, 0.3, 0.02));  // inches
  const std::string text = preview_text(shown(x));
  CHECK_THAT(text, Contains("remark: ") && Contains("box.stl") &&
                       Contains("taken as inches it would be 10.16 x 7.62"));
  f.file("box.stl", box(4.0, 3.0, 0.2, true));
  CHECK_THAT(preview_text(shown(x)), Contains("the surface is open"));
}

TEST_CASE(
    "The ice lab refuses a mesh of another unit before it is sliced, and says that one is open or tiny") {
  const test::TempFolder f;
  const std::filesystem::path x =
      f.file("x.toml", "include = \"" + std::string(FIRN_SOURCE_DIR) +
                           "/labs/ice-cobra600.toml\"\nice.mesh = \"part.stl\"\n");
  f.file("part.stl", box(30000.0, 20000.0, 30000.0));
  CHECK_THROWS_WITH(shown(x), Contains("ice.mesh") && Contains("30000 x 20000 x 30000 mm") &&
                                  Contains("the arm's reach") && Contains("1200 x 1200 x 210 mm") &&
                                  Contains("a scale of at most 0.007"));
  f.file("part.stl", box(3.0, 3.0, 1.2));
  CHECK_THAT(preview_text(shown(x)), Contains("taken as inches it would be 76.2 x 76.2 x 30.48 mm"));
  f.file("part.stl", box(20.0, 20.0, 1.2, true));
  CHECK_THAT(preview_text(shown(x)), Contains("the surface is open"));
  f.file("part.stl", box(20.0, 15.0, 2.4));
  const PrintPreview p = shown(x);
  CHECK(p.layers == 10);
  CHECK(p.remarks.empty());
  CHECK(p.outside.empty());
  CHECK(p.size_mm[0] > 20.0);  // with its scaffold
  CHECK(p.size_mm[0] < 30.0);
  CHECK(p.materials.front().second == Approx(20.0 * 15.0 * 2.4).epsilon(0.2));
  CHECK(p.amount > 1000);
  CHECK_THAT(preview_text(shown(x, {"ice.origin_x_mm=1000"})), Contains("OUTSIDE: layer 1"));
}
