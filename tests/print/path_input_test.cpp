// A path file of firn slice as the part of a print along paths.
#include "print/inputs/path_input.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "cli/print_command.h"
#include "cli/slice_command.h"
#include "config/error.h"
#include "config/include.h"
#include "files/usage_error.h"
#include "print/inputs/ice_inputs.h"
#include "print/labs/full_product.h"
#include "print/simulated/memory_print.h"
#include "tests/files/record/scratch.h"

using namespace firn;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

const fs::path kFolder = fs::path(FIRN_SOURCE_DIR) / "experiments";

struct Part {
  Experiment experiment;
  Blobs inputs;
};

Part part_of(const std::vector<std::string>& overrides) {
  Part p{load_experiment(kFolder / "ice-small.toml", overrides), {}};
  p.inputs = make_inputs(full_product(), p.experiment, kFolder);
  complete_experiment(full_product(), p.experiment, p.inputs);
  return p;
}

std::vector<std::string> from(const fs::path& file, std::vector<std::string> more = {}) {
  more.push_back("ice.mesh=\"\"");
  more.push_back("ice.paths=\"" + file.string() + "\"");
  return more;
}

/// firn slice of the small block with the ice lab's settings.
fs::path sliced(const test::Scratch& scratch, std::vector<std::string> overrides) {
  SliceCommandOptions o;
  o.meshes = {(kFolder / "ice-small.stl").string()};
  o.config = (kFolder / "slicing" / "ice.toml").string();
  o.output = (scratch / "block.paths").string();
  o.overrides = {"layer.height_mm=0.24"};
  o.overrides.insert(o.overrides.end(), overrides.begin(), overrides.end());
  REQUIRE(run_slice(o) == 0);
  return o.output;
}

std::string refusal(const fs::path& file, const std::vector<std::string>& more = {}) {
  try {
    part_of(from(file, more));
  } catch (const ConfigError& e) {
    CHECK(std::string(e.what()).find(file.filename().string()) != std::string::npos);
    return e.what();
  }
  return "";
}

}  // namespace

TEST_CASE("firn slice --experiment writes a path file whose print is that of the mesh, to the last bit") {
  const test::Scratch scratch("path-input");
  SliceCommandOptions o;
  o.experiment = (kFolder / "ice-small.toml").string();
  o.output = (scratch / "small.paths").string();
  REQUIRE(run_slice(o) == 0);

  const Part mesh = part_of({"ice.height_mm=1.2"}), paths = part_of(from(o.output, {"ice.height_mm=1.2"}));
  REQUIRE(paths.inputs.size() == mesh.inputs.size());
  for (std::size_t n = 0; n < mesh.inputs.size(); ++n) {
    CHECK(paths.inputs[n].role == mesh.inputs[n].role);
    CHECK(paths.inputs[n].bytes == mesh.inputs[n].bytes);
  }
  const MemoryPrintReport a = print_in_memory(full_product(), mesh.experiment, mesh.inputs);
  const MemoryPrintReport b = print_in_memory(full_product(), paths.experiment, paths.inputs);
  INFO(b.result.reason);
  CHECK(b.result.status == 0);
  CHECK(b.result.layers == a.result.layers);
  CHECK(b.droplets == a.droplets);
  CHECK(b.error.rms_mm == a.error.rms_mm);
  CHECK(b.node_s == a.node_s);
}

TEST_CASE("A path file of plain firn slice with measurement paths over its one material is printed") {
  const test::Scratch scratch("path-input-plain");
  const fs::path file = sliced(scratch, {"support.kind=none", "measure.on=1", "measure.spacing_mm=1.5"});
  const Part part = part_of(from(file, {"ice.height_mm=1.2", "process.min_measured_fraction=0.5"}));
  const MemoryPrintReport print = print_in_memory(full_product(), part.experiment, part.inputs);
  INFO(print.result.reason);
  CHECK(print.result.status == 0);
  CHECK(print.droplets > 100);
}

TEST_CASE("A path file that the lab cannot print is refused by file, layer, value and limit") {
  const test::Scratch scratch("path-input-refused");
  const fs::path plain = sliced(scratch, {});
  CHECK_THAT(refusal(plain),
             Contains("layer 5 ends an interval of ice.interval_layers = 5") && Contains("--experiment"));
  CHECK_THAT(refusal(plain, {"ice.layer_height_mm=0.25"}),
             Contains("layer 1 is 0.24 mm high, ice.layer_height_mm = 0.25 mm"));
  CHECK_THAT(refusal(sliced(scratch, {"measure.on=1"})), Contains("over material 1 (\"scaffold\")"));
  CHECK_THAT(refusal(sliced(scratch, {"support.kind=none", "measure.on=1", "part.tool=syrup"})),
             Contains("material 0 (\"part\") has the tool \"syrup\""));
  CHECK_THAT(refusal(sliced(scratch, {"support.kind=none", "measure.on=1", "measure.laser_x_mm=3"})),
             Contains("measure.laser_x_mm = 0"));
  CHECK_THAT(refusal(sliced(scratch, {"support.kind=none", "mesh.material=[2]"})),
             Contains("material 2") && Contains("2 materials"));
  CHECK_THAT(refusal(scratch / "none.paths"), Contains("No such file"));
}

TEST_CASE(
    "A damaged or unfinished path file is refused with the byte, and so is a part that is given twice") {
  const test::Scratch scratch("path-input-damaged");
  const fs::path file = sliced(scratch, {"support.kind=none", "measure.on=1"});
  const auto size = fs::file_size(file);
  {
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(std::streamoff(size / 2));
    bytes.put('\x5a');
  }
  CHECK_THAT(refusal(file), Contains("damaged") && Contains("byte"));
  fs::resize_file(file, 100);
  CHECK_FALSE(refusal(file).empty());
  CHECK_THROWS_WITH(load_experiment(kFolder / "ice-small.toml", {"ice.paths=\"x.paths\""}),
                    Contains("ice.mesh"));
}

TEST_CASE("Paths of a file that the arm cannot reach are refused before there is a run") {
  const test::Scratch scratch("path-input-reach");
  const fs::path file = sliced(scratch, {"support.kind=none", "measure.on=1"});
  const Part part = part_of(from(file, {"ice.origin_x_mm=700"}));
  PrintOptions o;
  o.bus = "in-process";
  o.runs = (scratch / "runs").string();
  CHECK_THROWS_WITH(print_experiment(full_product(), part.experiment, part.inputs, o),
                    Contains("out of reach, nothing is printed: layer 1, deposition path"));
  CHECK_FALSE(fs::exists(scratch / "runs"));
}
